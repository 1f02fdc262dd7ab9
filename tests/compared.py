"""How blocks compare with what is known, by the engine's own compiled loops."""

import numpy as np

from kwatra.pieces.choosing.charges import around
from kwatra.pieces.choosing.comparing import compare, sum_near, take_known
from kwatra.pieces.choosing.seen import Seen


def mismatch(agreement, places, known, valid):
    """What an `Agreement` finds of boxes whose known pixels come from places (b, *E) of a mosaic, (b, images, *n)."""
    boxes, extent, (planes, images) = len(known), known.shape[1:], agreement.taken
    ones = np.empty((boxes, len(planes) + 1, known[0].size), np.float32)
    against, valid = np.empty((boxes, images.max() + 2, known[0].size)), valid.reshape(boxes, -1)
    take_known(planes, images, places.reshape(boxes, -1), known.reshape(boxes, -1), ones, against)
    few, flat = np.zeros(boxes, int), against.reshape(boxes, -1, 1, *extent)
    seen = Seen(places, known, few > 0, few, ones, flat, valid, 0.0 * valid)
    found = np.empty((boxes, images.max() + 1, valid.shape[1]))
    compare(agreement.compared(seen), valid, found)
    return found.reshape(*found.shape[:2], *agreement.corners.valid.shape)


def shown_near(sheet, boxes, corners, twins):
    """How much of each block (b, n) of an image is shown around boxes."""
    near = np.empty((len(boxes), corners.valid.size))
    sum_near(around(sheet, boxes, corners, twins), near)
    return near
