"""What may happen to a pixel where a patch is cut in."""

KEEP, TAKE, FREE, VOID = 0, 1, 2, 3
"""It keeps its patch, takes the new one, may do either, or is empty and stays so."""

MOST = 1 << 62
"""More than any cut costs."""
