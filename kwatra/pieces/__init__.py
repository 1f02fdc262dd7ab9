"""Pieces of texture, laid along seams."""

from kwatra.pieces.start import BlockStart, block_size

__all__ = ["BlockStart", "block_size"]
