"""The exemplar's blocks, searched for those that agree with what is known of given ones.

Agreement is the squared difference over the known pixels, for every place at once by correlation, as in entire-patch
matching (thesis section 3.2). Where there are gaps between elements, they are to lie where gaps are, as in stills: so
seams find a way around elements. Of a scene blocks rather come from where in its frame they came from before.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from flow.animation.film import Film, nearest_pixels
from kwatra import Exemplar
from kwatra.base import InputError, box_sums, mean
from kwatra.pieces import Fit, Hidden
from kwatra.source import look_up
from kwatra.terms.stay import REACH, STAYING

_AT_ONCE = 1 << 17
"""A video's blocks are looked for in pages that have about so many pixels together, and in two at least."""

_ELEMENTS = 2
"""Where seams are hidden between elements that are not drawn whole blocks are so many elements wide at least: smaller
ones hold none. Of made stones, buttons, pebbles on sand and bolts on metal of 28 px, which are drawn whole, motion
in a pair of vortices is off by .21 px and flickers by .094 with usual blocks (60 frames), .25 and .105 with such,
and as few are cut."""

_HOME = 0.5
"""What a block costs that is not from where it belongs, in what windows do in synthesis. A waterfall that moves by 2 px
a frame is agitated by .58 of what its clip is with 1, .60 with this, a fountain in vortices by .63 and .66."""

_RIM = 1 / 6
"""The part of a block's side, at either end, over which the wear that it saves is guessed less, down to nothing. Tried:
.197 with half as much, .205 with twice as much."""


class Blocks:
    """Blocks of `sides` (height, width) px, halved until one fits into the exemplar.

    hidden: where gaps hide seams between elements of a picture; None where they do nowhere.
    """

    def __init__(self, film: Film, sides: tuple[int, int], hidden: Hidden | None = None) -> None:
        self._deep = hidden is not None
        self._compared = exemplar = film.described if hidden is None else _with_depth(film.described, hidden)
        page = film.cut(exemplar, [0])
        while max(sides) > 2 and not bool(page.corners(sides).any()):
            sides = max(sides[0] // 2, 2), max(sides[1] // 2, 2)
        if min(sides) < 2 or not bool(page.corners(sides).any()):
            raise InputError("no 2x2 block fits into the exemplar; its mask leaves too little to copy from")
        self.sides, self._film = sides, film
        self._staying = _HOME * STAYING / REACH**2 * exemplar.variance
        self._root = exemplar.share.sqrt()
        known = exemplar.owner >= 0
        self._middle = torch.stack([mean(channel[known]) for channel in exemplar.canvas]).view(-1, 1, 1)
        self._valid: dict[int, np.ndarray] = {}
        self._pages: list[int] = []
        self._turn([0])

    def seen(self, image: Tensor, source: Tensor) -> Tensor:
        """What blocks are compared by of an image (C, H, W) that shows source coordinates (2, H, W), x first.

        It is the image, (C, H, W), and where gaps hide seams how deep in its element each place lies, (C + 1, H, W).
        """
        if not self._deep:
            return image
        depth = self._compared.canvas[-1:]
        return torch.cat([image, look_up(depth, nearest_pixels(source, depth.shape[1:]))])

    def _scaled(self, colors: Tensor) -> np.ndarray:
        scaled: np.ndarray = ((colors - self._middle) * self._root).double().numpy()
        return scaled

    def _turn(self, pages: list[int]) -> None:
        """Look for blocks in some pages alone, and wherever none is masked."""
        if pages != self._pages:
            part = self._film.cut(self._compared, pages)
            self._pages = pages
            self._fit = Fit(self._scaled(torch.where(part.owner >= 0, part.canvas, self._middle)))

    def _drawn(self, generator: torch.Generator) -> list[int]:
        """Some of the pages from which texture can live on; of a picture its one."""
        first, last = self._film.starts
        if first == last:
            return [first]
        count = max(_AT_ONCE // (self._film.pitch * self._film.strip.shape[1]), 2)
        return sorted((first + torch.randperm(last - first + 1, generator=generator)[:count]).tolist())

    def nearest(
        self,
        content: Tensor,
        known: Tensor,
        used: Callable[[Tensor], Tensor],
        generator: torch.Generator,
        homes: Sequence[Tensor | None] | None = None,
        more: Sequence[int] | None = None,
    ) -> Tensor:
        """Corners (n, 2), x first, of the blocks nearest to contents (n, C, *sides) where known (n, 1, *sides).

        Contents are as `seen` has them. known weighs the pixels, >= 0; of a block of which nothing is known any may
        come. used: what each pixel of some rows (r,) of the strip costs, as a mean square difference, (r, W). homes:
        for each block a corner (2,), x first, in whatever frame, near which it should lie, as `kwatra.Stay` has it;
        None where any place is as good.
        more: by how many px more the exemplar goes on around each block; where it does nowhere that is an error.
        """
        self._turn(self._drawn(generator))
        costs = used(self._film.rows(self._pages))
        again = box_sums(costs.double().numpy(), self.sides) / math.prod(self.sides)
        weights = known[:, 0].double().numpy()
        none = [None] * len(content)
        found = []
        for block, weight, home, beyond in zip(content, weights, homes or none, more or none, strict=True):
            valid = self._around(beyond or 0)
            if weight.max() == 0:
                places = np.argwhere(valid)
                found.append(places[int(torch.randint(len(places), (1,), generator=generator))])
                continue
            away = 0.0 if home is None else self._away(*home.tolist())
            cost = self._fit.inside(self._scaled(block), weight) + weight.sum() * (again + away)
            found.append(np.unravel_index(np.where(valid, cost, np.inf).argmin(), cost.shape))
        corners = torch.from_numpy(np.array(found)).T
        return self._film.uncut(corners, self._pages).T.flip(1)

    def holds(self, more: int) -> bool:
        """Whether the exemplar goes on by so many px more around any block, on all sides."""
        return bool(self._around(more).any())

    def _around(self, more: int) -> np.ndarray:
        """At which corners a block lies with so many px more around it; pages are alike in what may be copied."""
        (height, width), across = self.sides, self._film.strip.shape[1]
        if more not in self._valid:
            page = self._film.cut(self._film.described, [0])
            wide = page.corners((height + 2 * more, width + 2 * more)).numpy()
            valid = np.zeros((self._film.pitch, across - width + 1), bool)
            valid[more : more + wide.shape[0], more : more + wide.shape[1]] = wide
            self._valid[more] = valid
        valid = np.tile(self._valid[more], (len(self._pages), 1))
        return valid[: len(valid) - height + 1]

    def _away(self, x: float, y: float) -> np.ndarray:
        """What the blocks at all corners cost for how far from a place in their frames they lie, by shares of these."""
        height, width = self._film.pitch, self._film.strip.shape[1]
        down, right = (np.arange(side) for side in self._around(0).shape)
        cost: np.ndarray = self._staying * (((down % height - y) / height)[:, None] ** 2 + ((right - x) / width) ** 2)
        return cost


def bell(sides: Sequence[int]) -> Tensor:
    """A Gaussian over a block (h, w) that is 1 in its middle, with a deviation of .28 of its sides."""
    down, right = (torch.exp(-((line - (n - 1) / 2) / (0.4 * n)).square()) for line, n in _lines(sides))
    return down[:, None] * right


def inner(sides: Sequence[int]) -> Tensor:
    """1 within a block (h, w), less toward its ends over a part of its sides, down to 0."""
    down, right = ((line / (_RIM * n)).clamp(max=1) for line, n in _lines(sides))
    return down.minimum(down.flip(0))[:, None].minimum(right.minimum(right.flip(0)))


def _lines(sides: Sequence[int]) -> list[tuple[Tensor, int]]:
    return [(torch.arange(n, dtype=torch.float32), n) for n in sides]


def side_of(size: int, hidden: Hidden | None) -> int:
    """The side of blocks: that asked for, or what holds whole elements; at most half of the exemplar's."""
    if hidden is None:
        return size
    return max(size, min(round(_ELEMENTS * hidden.size), min(hidden.depth.shape) // 2))


def _with_depth(exemplar: Exemplar, hidden: Hidden) -> Exemplar:
    """An exemplar with one more channel: how deep in its element each place lies, as unlike as its colors are."""
    deviation = exemplar.variance**0.5
    depth = torch.from_numpy(hidden.unlike * np.float32(deviation))[None]
    weight = hidden.aligned * hidden.hides * exemplar.weights.sum(0, keepdim=True)
    return replace(exemplar, canvas=torch.cat([exemplar.canvas, depth]), weights=torch.cat([exemplar.weights, weight]))
