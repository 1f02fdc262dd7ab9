"""Placements that would fold the picture: a mirrored copy laid so that it shows, about a line, what is there already.

Near the line both show the same pixels of the exemplar, so they match, and a seam along it costs next to nothing; what
is seen is a kaleidoscope. Where such lines lie is told by coordinates alone. If source n shows at V(u) what the
exemplar shows at u, then a sheet pixel p that shows u is met by its own image in one placement, t = p - V(u). A fold
is a placement that many pixels name, or nearly.
"""

from __future__ import annotations

import numpy as np

from kwatra.base import box_sums
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Sheet

RADIUS = 8
"""How far apart, in pixels, the same may be shown again: half of it on either side of a fold."""
_CHUNK = 1 << 18


def folded(sheet: Sheet[Mosaic], number: int, span: Box, reach: Box) -> np.ndarray:
    """How long a fold, in pixels, each translation in `span` of source `number` would make with what is in `reach`.

    In video a fold is a surface, and its length the sum over frames. Memory grows with `span`; `reach` goes by slabs.
    """
    sources = sheet.sources
    rim = np.array([0] * (len(span.extent) - 2) + [RADIUS] * 2)
    low, size = np.array(span.start) - rim, tuple(np.array(span.extent) + 2 * rim)
    votes = np.zeros(int(np.prod(size)), np.int64)
    for slab in _slabs(reach.clipped(sheet.shape, sheet.periodic)):
        at = sheet.indices(slab)
        home, shown = sources.coordinates(sheet.places[at])
        for other in sources.mirrored(number):
            here = sheet.filled_at(at) & (home == other)
            pixel = np.stack(np.nonzero(here)) + np.array(slab.start)[:, None]
            vote = pixel - sources.moved(shown[:, here], other, number) - low[:, None]
            vote = vote[:, ((vote >= 0) & (vote < np.array(size)[:, None])).all(0)]
            votes += np.bincount(np.ravel_multi_index(tuple(vote), size), minlength=len(votes))
    return box_sums(votes.reshape(size), tuple(2 * rim + 1)) / (RADIUS + 1)


def _slabs(box: Box) -> list[Box]:
    """The box in pieces along axis 0 of about `_CHUNK` pixels at most."""
    thick = max(_CHUNK // max(int(np.prod(box.extent[1:])), 1), 1)
    firsts = range(0, box.extent[0], thick)
    return [Box((box.start[0] + f, *box.start[1:]), (min(thick, box.extent[0] - f), *box.extent[1:])) for f in firsts]
