"""A picture, parts of which are covered by patches of an exemplar, sewn to it and to each other.

Each patch is laid where it fits what is around it, and cut along the seam of least cost (Kwatra et al. 2003, section
3.1), which keeps elements whole; patches then replace each other where that lowers the cost of all seams. In a texture
that runs along an axis, as wood does, seams cost less beside its lines (`kwatra.elements.easier`), in one of elements
along their gaps or outlines (`kwatra.pieces.hidden_seams`). Steps of color along seams are spread over some pixels by
the picture x whose gradients are nearest to those of the patches,

    sum_(s,t) (x_t - x_s - g_st)^2 + (x - c)^2 / REACH^2,    x = c where the picture stays,

c the colors of the patches and g their differences, across a seam the mean of both patches' (Perez, Gangnet and Blake
2003, "Poisson Image Editing", screened); across one that is hidden the step itself, which is that of an element's end.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import every_pair, membrane
from kwatra.elements import anisotropy, easier, runs_along
from kwatra.loop import FIBROUS
from kwatra.pieces import Box, Cut, Hidden, Mosaic, Patch, SeamCost, Sheet, hidden_seams
from kwatra.pieces.choosing import Fit
from kwatra.pieces.seams import eased
from kwatra.pieces.sheet import Offer, cheapest_cuts

CANDIDATES = 12
"""Of so many places that fit best the one whose cut costs least is taken. With 4 stones were cut that 12 left whole;
tuned, as REACH, by eye on tiles of gravel, radishes, a stone wall and peeling plaster."""

REFINED = 2
"""The same of a patch whose place is known from a coarser resolution. Of tiles of five made textures, 1024 pixels a
side, .033 of the elements are mixed, as with 4; .038 with 1."""

APART = 2
"""Candidates are further than so many pixels from each other."""

REACH = 8.0
"""Over about so many pixels steps of color are spread."""

ENOUGH = 1000
"""Where patches are looked for nearby only, and fewer places than this have one, they are looked for further away: a
guard, not tuned."""

GRID = 64
"""The parts of an exemplar that are looked through begin at multiples of so many pixels: boxes beside each other share
one, and its transforms, of which KEPT are kept."""

KEPT = 16


class Sewing:
    """What is laid of a picture of some `shape`, closed along some axes, and of an exemplar's patches.

    The picture is given (C, *shape), or what the exemplar's canvas begins with. near: patches are sought on so many
    pixels about where they are laid, which bounds time and memory, as if the picture lay on the canvas from `first` on.
    sheet: what is laid; pixels that are `fixed` there stay. laid: what was sewn in, in order: boxes, and where on the
    canvas their patches begin. runs: the axis along which the texture runs, None for none.
    """

    def __init__(
        self,
        exemplar: Exemplar,
        shape: Sequence[int],
        near: int,
        closed: Sequence[bool] = (False, False),
        picture: Tensor | None = None,
        first: Sequence[int] = (0, 0),
    ) -> None:
        self.exemplar, self.first, self.near = exemplar, tuple(first), near
        self.runs = runs_along(anisotropy(exemplar), FIBROUS)
        self.closed, self.shape = tuple(closed), tuple(shape)
        self.mosaic = Mosaic([each.cpu().numpy() for each in (exemplar.canvas, picture) if each is not None])
        hidden = hidden_seams(exemplar) if picture is None and self.runs is None else None
        self.sheet = Sheet(self.mosaic, self.shape, self.closed, self._seam_cost(hidden))
        self.laid = list[tuple[Box, tuple[int, ...]]]()
        self._fit = lru_cache(KEPT)(partial(_fit_of, self.mosaic.matching(0)))
        self._valid = lru_cache(KEPT)(partial(_places_of, exemplar))

    def _seam_cost(self, hidden: Hidden | None) -> SeamCost:
        """What seams cost: less in gaps between elements, or else beside lines of a texture that runs along an axis."""
        if hidden is None:
            return eased(self.mosaic, easier(anisotropy(self.exemplar), self.runs))
        return hidden.cost(self.mosaic, [...], self.mosaic.deviation)

    def lay_picture(self, box: Box, must_not: np.ndarray | None = None) -> None:
        """Lay the picture itself in a box, but for those pixels of it (boolean) that are not to show it."""
        self.sheet.lay(Patch(len(self.mosaic.images) - 1, (0, 0), box), must_not=must_not)

    def sew(self, boxes: Sequence[Box], turns: int, report: Callable[[float], None]) -> None:
        """Cover what is empty in boxes, one after the other, then try all again: so many turns; report: what is done.

        Boxes are as large as patches that the exemplar has.
        """
        for turn in range(turns):
            for number, box in enumerate(boxes):
                self._sew_in(box, *self._where_to_look(box), CANDIDATES, again=turn > 0)
                report((turn + (number + 1) / len(boxes)) / turns)

    def follow(self, coarse: "Sewing", factor: int, report: Callable[[float], None]) -> None:
        """Sew in what was sewn of the same picture `factor` times coarser, each patch where it fits best nearby.

        Boxes keep their distance to the border that is nearer: of the picture the last pixels may make no coarse one.
        """
        covered = set[Box]()
        for number, (there, place) in enumerate(coarse.laid):
            sides = zip(there.start, there.extent, coarse.shape, self.shape, strict=True)
            start = [factor * a if 2 * a + e <= n else size - factor * (n - a) for a, e, n, size in sides]
            box = Box(tuple(start), tuple(factor * e for e in there.extent))
            low = tuple(max(factor * p - factor, 0) for p in place)
            lines = zip(low, place, box.extent, self.exemplar.shape, strict=True)
            part = Box(low, tuple(min(factor * (p + 1) + e, size) - a for a, p, e, size in lines))
            valid = self._valid(box.extent)[Box((0, 0), self.exemplar.shape).part(_begins_of(part, box))]
            self._sew_in(box, part, valid, REFINED, again=box in covered)
            covered.add(box)
            report((number + 1) / len(coarse.laid))

    def _sew_in(self, box: Box, part: Box, valid: np.ndarray, count: int, again: bool) -> None:
        """Cut in, of so many patches that fit a box best, the one of the least price; again: if that lowers all seams.

        part: where on the canvas they are sought; valid: where in it they may begin.
        """
        cut = self._cheapest(box, part, valid, count)
        if (not again and not self.sheet.full(box)) or cut.price < 0:
            self.sheet.commit(cut)
            self.laid.append((box, tuple(b - s for b, s in zip(box.start, cut.patch.shift, strict=True))))

    def _cheapest(self, box: Box, part: Box, valid: np.ndarray, count: int) -> Cut:
        """Of so many patches that fit a box best the one that can be cut in at the least price."""
        at = self.sheet.indices(box)
        known = self.sheet.filled_at(at).astype(np.float32)
        cost = self._fit(part).inside(self.mosaic.matching_at(self.sheet.places[at]) * known, known)
        cost[~valid] = np.inf
        shifts = list[tuple[int, ...]]()
        while len(shifts) < count and np.isfinite(cost).any():
            place = np.unravel_index(int(cost.argmin()), cost.shape)
            shifts.append(tuple(int(b - s - p) for b, s, p in zip(box.start, part.start, place, strict=True)))
            cost[tuple(slice(max(p - APART, 0), p + APART + 1) for p in place)] = np.inf
        nothing, alike = np.zeros(len(shifts)), np.ones(len(shifts))
        windows, firsts = self.sheet.windows([box]), np.array([0, len(shifts)])
        cut = cheapest_cuts(self.sheet, Offer(windows, [box], firsts, np.array(shifts), nothing, alike, np.inf))[0]
        assert cut is not None  # whatever it costs
        return cut

    def _where_to_look(self, box: Box) -> tuple[Box, np.ndarray]:
        """The part of the canvas in which patches for a box are sought, and where in it they may begin."""
        everywhere, side = self._valid(box.extent), self.near
        while True:
            part = self._about(box, side)
            valid = everywhere[Box((0, 0), self.exemplar.shape).part(_begins_of(part, box))]
            if part.extent == self.exemplar.shape or int(valid.sum()) >= ENOUGH:
                return part, valid
            side *= 2

    def _about(self, box: Box, side: int) -> Box:
        """The part of the canvas of about so many pixels a side around what a box shows of it, on GRID."""
        first, extent = list[int](), list[int]()
        for start, size, begin, there in zip(box.start, box.extent, self.first, self.exemplar.shape, strict=True):
            low = min((begin + start + size // 2 - side // 2) // GRID * GRID, there - side)
            first.append(max(low, 0))
            extent.append(min(side + GRID, there - first[-1]))
        return Box(tuple(first), tuple(extent))

    @property
    def places(self) -> Tensor:
        """Where on the canvas each pixel comes from, (2, H, W); of a picture that was given, where in that."""
        return torch.from_numpy(self.mosaic.coordinates(self.sheet.places)[1].astype(np.int64))

    def patches(self) -> Tensor:
        """The picture (C, H, W) as its patches have it."""
        return torch.from_numpy(self.mosaic.originals(self.sheet.places))

    def blended(self) -> Tensor:
        """The picture (C, H, W) that has, as nearly as can be, the patches' gradients and no steps between them."""
        free, steps = torch.from_numpy(~self.sheet.fixed), [self._missing(axis) for axis in (0, 1)]
        return self.patches() + membrane(free, every_pair(self.shape, self.closed), steps, REACH)

    def _missing(self, axis: int) -> Tensor:
        """Differences (C, H, W) to the next pixel along an axis: both patches' mean less that of the colors.

        Where a seam is hidden nothing is missing.
        """
        places = self.sheet.places
        after, ahead = np.roll(places, -1, axis), self.mosaic.beyond(places, axis, 1)
        at = np.nonzero(ahead != after)  # elsewhere one patch goes on
        here, ahead, there = places[at], ahead[at], after[at]
        back = self.mosaic.beyond(there, axis, -1)
        ours, beyond, before, theirs = (self.mosaic.originals(each[None])[:, 0] for each in (here, ahead, back, there))
        steps = ((beyond - ours) + (theirs - before)) / 2 - (theirs - ours)
        depth = self.sheet.cost.depth
        missing = np.zeros((len(ours), *self.shape), np.float32)
        missing[:, at[0], at[1]] = steps if depth is None else steps * depth.of_seam(here, back, ahead, there)
        return torch.from_numpy(missing)


def _begins_of(part: Box, box: Box) -> Box:
    """Where in a part of the canvas patches for a box may begin."""
    return Box(part.start, tuple(there - here + 1 for there, here in zip(part.extent, box.extent, strict=True)))


def _fit_of(canvas: np.ndarray, part: Box) -> Fit:
    """How patches of a part of a canvas (C, H, W) are fitted."""
    lines = zip(part.start, part.stop, strict=True)
    return Fit(canvas[(slice(None), *(slice(low, high) for low, high in lines))])


def _places_of(exemplar: Exemplar, extent: tuple[int, ...]) -> np.ndarray:
    """Where on the canvas patches of some extent may begin."""
    return exemplar.corners(extent).cpu().numpy()
