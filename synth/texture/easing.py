"""Seams of stills are eased: colors that meet there go on as they do within pieces.

Where all around is smooth, as in water or in the grain of a plank, a step of a few percent is seen however well it was
chosen. So the still x gets the corrections c that make

    sum_pq |x_q + c_q - x_p - c_p - g_pq|^2 + FADING sum_p |c_p|^2

least over all steps from p to q, with g what the exemplar's colors change by there: on a seam as both sides say, and
within a piece as it shows. These are Poisson equations (Perez, Gangnet and Blake 2003, "Poisson Image Editing"), but
for FADING, with which corrections stay near the seam: pieces are copies everywhere else, bit for bit.
"""

import torch
from torch import Tensor

from kwatra import Exemplar
from synth.texture.steps import corrections, lacking

FADING = 0.3
"""A correction fades within so many px as the inverse of this has a root, two. By eye, on water, planks and stone. Two
panels of 16 textures, two seeds, score .0543 and .0482 without, .0546 and .0481 with it; of one of them, as the engine
measures, .0376 becomes .0385 with .1, as fewer pixels are copies then."""

APART = 2
"""Places that go on within so many pixels are one piece, which may be warped."""

OUTLINE = 0.3
"""Steps that lack more in any channel, of its range, are outlines of things rather than steps of color, and would get a
halo. By eye, on water and stripes."""

UNSEEN = 1e-3
"""Smaller corrections are left out: a quarter of what a picture of 8 bits tells apart."""


def eased(still: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...]) -> Tensor:
    """A still (C, H, W) with its seams eased, where the map (2, H, W) says where on the exemplar's canvas it is from.

    wrap: whether rows and columns are periodic. Colors stay within the range that each channel has in the exemplar.
    Memory: some arrays of the output's size.
    """
    image, places, around = still.cpu(), where.cpu(), exemplar.to("cpu")
    pull = torch.zeros_like(image).flatten(1)
    for axis, wraps in enumerate(wrap, 1):
        seam = _seams(places, axis, wraps)
        lack = _lacking(image, places, around, axis, seam)
        pull[:, seam[0]] -= lack
        pull[:, seam[1]] += lack
    if not bool(pull.any()):
        return still
    changed = torch.from_numpy(corrections(pull.view(image.shape).numpy(), wrap, FADING))
    known = around.canvas[:, around.owner >= 0]
    low, high = (edge.view(-1, 1, 1) for edge in (known.amin(1), known.amax(1)))
    same = changed.abs() < UNSEEN
    changed.add_(image).clamp_(low, high)
    return torch.where(same, image, changed, out=changed).to(still)


def _seams(where: Tensor, axis: int, wraps: bool) -> Tensor:
    """The pixels (2, n), by number, that do not go on in the next one along an axis, and these."""
    _, height, width = where.shape
    step = (torch.cat([where, where.narrow(axis, 0, 1)], axis) if wraps else where).diff(dim=axis)
    onward = int(axis == 1), int(axis == 2)
    off = [(along < usual - APART) | (along > usual + APART) for along, usual in zip(step, onward, strict=True)]
    row, column = (off[0] | off[1]).nonzero().T
    following = (row + onward[0]) % height * width + (column + onward[1]) % width
    return torch.stack([row * width + column, following])


def _lacking(image: Tensor, where: Tensor, exemplar: Exemplar, axis: int, seam: Tensor) -> Tensor:
    """What steps between pixels of a seam (2, n) along an axis lack, (C, n); 0 of outlines."""
    colors, places = (torch.stack([each.flatten(1)[:, side] for side in seam], axis) for each in (image, where))
    lack = lacking(colors, places, exemplar, axis, False).squeeze(axis)
    return lack * (lack.abs().amax(0) < OUTLINE)
