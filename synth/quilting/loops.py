"""Stretches of a sheet that repeat in time: laid twice, and unrolled."""

from __future__ import annotations

import numpy as np

from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Sheet


def adopt(sheet: Sheet[Mosaic], other: Sheet[Mosaic], first: int) -> None:
    """Copy another sheet of the same cross-section in as the steps `first`... of axis 0, and fix its pixels."""
    at = slice(first, first + other.shape[0])
    sheet.total += other.total - int(sheet.seams[:, at].sum(dtype=np.int64))
    sheet.label[at] = other.label + len(sheet.patches)
    sheet.places[at] = other.places
    sheet.seams[:, at] = other.seams
    sheet.fixed[at] = True
    sheet.patches += [patch.moved(first) for patch in other.patches]


def unrolled(sheet: Sheet[Mosaic], first: int, margin: int) -> Sheet[Mosaic]:
    """The loop that the steps of axis 0 from `first` on are, `margin` steps of its other turns on either side.

    It shows what lies around each pixel of the loop; patches and places are set, seams are not.
    """
    period = sheet.shape[0] - first
    turn, at = np.divmod(np.arange(-margin, period + margin), period)
    longer = Sheet(sheet.sources, (len(at), *sheet.shape[1:]), sheet.periodic, sheet.cost)
    longer.places[:] = sheet.places[first + at]
    turns = np.unique(turn)
    number = (turn - turns[0]) * len(sheet.patches)
    longer.label[:] = sheet.label[first + at] + number.reshape(-1, *[1] * (len(sheet.shape) - 1))
    for step in turns * period + margin - first:
        longer.patches += [patch.moved(int(step)) for patch in sheet.patches]
    return longer
