"""Where a source's border may lie: a seam along it would be a straight line, and nothing lies behind it to blend into.

So a patch ends a margin before its source does, except where the output ends no later: there no seam can be. And with
`inside`, no source reaches past the output: the border of what is copied is then seen at the output's border or not
at all, which keeps the ground of a scene at the bottom.
"""

from __future__ import annotations

import numpy as np

from kwatra.pieces.boxes import Box, everywhere


def margins(source: tuple[int, ...], region: tuple[int, ...], wanted: tuple[int, ...]) -> tuple[int, ...]:
    """As much of the `wanted` margin per axis as leaves sources of this shape some room to move over a region."""
    return tuple(min(m, max(n - e, 0) // 4) for n, e, m in zip(source, region, wanted, strict=True))


def trimmed(source: Box, shape: tuple[int, ...], periodic: tuple[bool, ...], margin: tuple[int, ...]) -> Box:
    """The box of a source on an output of `shape` without the margin on the sides that lie inside."""
    start, extent = [], []
    for s, e, n, wraps, m in zip(source.start, source.stop, shape, periodic, margin, strict=True):
        low = s + (m if wraps or s > 0 else 0)
        high = e - (m if wraps or e < n else 0)
        start.append(low)
        extent.append(high - low)
    return Box(tuple(start), tuple(extent))


def admitted(
    span: Box,
    source: tuple[int, ...],
    region: Box,
    shape: tuple[int, ...],
    periodic: tuple[bool, ...],
    margin: tuple[int, ...],
    inside: bool,
) -> np.ndarray:
    """Which translations in `span` let a trimmed source cover `region` and, if asked, lie inside; boolean."""
    lines = []
    for axis, (first, last) in enumerate(zip(span.start, span.stop, strict=True)):
        low, n, m = np.arange(first, last), shape[axis], margin[axis]
        high = low + source[axis]
        loose = periodic[axis]
        fits = low + np.where((low > 0) | loose, m, 0) <= region.start[axis]
        fits &= high - np.where((high < n) | loose, m, 0) >= region.stop[axis]
        if inside and not loose:
            fits &= ((low >= 0) & (high <= n)) | ((low <= 0) & (high >= n))
        lines.append(fits)
    return everywhere(lines)


def homely(span: Box, drift: tuple[int, ...]) -> np.ndarray:
    """Which translations in `span` are at most `drift` on each axis, or, where none is, the shortest; boolean."""
    lengths = [np.abs(np.arange(first, last)) for first, last in zip(span.start, span.stop, strict=True)]
    return everywhere([length <= max(most, length.min()) for length, most in zip(lengths, drift, strict=True)])
