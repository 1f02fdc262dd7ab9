"""Metamorphosis: frames that lead from one texture to another, each of them a texture (one folder per method)."""
