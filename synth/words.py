"""Words of sentences that people read."""

from collections.abc import Sequence


def counted(count: int, noun: str) -> str:
    """A number of things: 1 frame, 2 frames."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def listed(things: Sequence[object]) -> str:
    """Things by name: a, b and c."""
    *first, last = map(str, things)
    return f"{', '.join(first)} and {last}" if first else last
