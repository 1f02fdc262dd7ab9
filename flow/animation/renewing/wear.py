"""How worn a carried frame is: its texture energy (thesis equation 18), pixel by pixel."""

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from flow.animation.carrying import angle_of, blurred, distortion, turned
from flow.animation.film import Film
from flow.animation.renewing.placing import Spot, widened
from kwatra import Grid
from kwatra.elements import drawn_sides
from kwatra.source import SourceWindows
from kwatra.windows import channels_last, windows_at

_BLUR = 1.0
"""Windows are compared after a blur of this many px, so that a fraction of a pixel between copies is no wear. Tried:
.192 with half, .224 with twice as much, with which a fourth of the blocks is renewed."""

_SETTLED = 1e-3
"""Wear up to which a window is not searched for something better than what it copies: a bound on time."""

_EXACT = 1 << 20
"""Up to so many pairs of windows the search is exact."""

_SEARCHED = 1 << 17
"""Of a video windows are looked for in pages that have about so many pixels together, and in two at least."""

_TURNED = 0.02
"""Windows of copies turned by less, in radians, are compared as if they were not: a bound on time."""

_REACH = math.ceil(4 * _BLUR)
"""How far, in px, the blur carries a change."""


@dataclass(frozen=True)
class Worn:
    """The wear (H, W) of a frame, and what it is made of: the blurred image (C, H, W), what each of its windows (N,)
    differs from the exemplar by, how copies are bent (H, W), and the angle (H, W) by which they are turned.
    """

    wear: Tensor
    smooth: Tensor
    energy: Tensor
    bent: Tensor
    angle: Tensor


class Wear:
    """Measures frames of `shape` (H, W) against an exemplar, by windows `width` px wide every `step` px.

    They are long and slim where it runs along an axis (`fibers`), if such windows fit. Values are in
    variances of the exemplar: 0 is a verbatim copy, 2 what two unrelated pixels have between them. Where copies may
    turn (`Film.turning`) a window is compared with what its copy shows turned as it is.
    """

    def __init__(self, film: Film, shape: tuple[int, int], width: int, step: int, area: float) -> None:
        exemplar = film.described
        pages = film.spread(max(_SEARCHED // (film.pitch * exemplar.shape[1]), 2))
        self.area, self._film = area, film
        self.variance = max(exemplar.variance, 1e-8)
        page = film.cut(exemplar, [0])
        sides, steps = (drawn_sides(side, film.along) for side in (width, step))
        if sides[0] > shape[0] or sides[1] > shape[1] or not bool(page.corners(sides).any()):
            fits = (w for w in range(min(width, *shape), 0, -1) if bool(page.corners((w, w)).any()))
            sides, steps = (next(fits, 1),) * 2, (step, step)
        steps = min(steps[0], sides[0]), min(steps[1], sides[1])
        sides = sides[0] - sides[0] % steps[0], sides[1] - sides[1] % steps[1]
        smooth = replace(exemplar, canvas=blurred(exemplar.canvas, exemplar.owner >= 0, _BLUR))
        self._pixels = channels_last(smooth.canvas)
        self.source = SourceWindows(film.cut(smooth, pages), sides, torch.Generator().manual_seed(0))
        self.grid = Grid(shape, sides, steps)
        pairs = len(self.grid) * len(self.source.numbers)
        self._route = "exact" if pairs <= _EXACT else "approximate"
        last = [film.pitch - sides[0], exemplar.shape[1] - sides[1]] if film.pages > 1 else [*self.source.positions]
        self._last = torch.tensor(last)
        every = torch.arange(len(self.grid))
        self._whole = slice(0, shape[0]), slice(0, shape[1])
        self._mass = self._sum(every, torch.ones(len(self.grid), dtype=torch.float32), self._whole)

    def __call__(self, image: Tensor, source: Tensor, inside: Tensor) -> Tensor:
        """Wear (H, W) of an image (C, H, W) with its source coordinates (2, H, W); 0 where not inside (H, W)."""
        return torch.where(inside, self.of(image, source).wear, 0.0)

    def of(self, image: Tensor, source: Tensor) -> Worn:
        """The wear of a frame: its image (C, H, W) and source coordinates (2, H, W)."""
        smooth = blurred(image, torch.ones_like(source[0], dtype=torch.bool), _BLUR)
        beside, every = turned(source), torch.arange(len(self.grid))
        angle, bent = angle_of(beside), distortion(source, beside)
        energy = self._energy(smooth, source, angle, every)
        return Worn(self._spread(every, energy, self._whole) + self.area * bent, smooth, energy, bent, angle)

    def after(self, worn: Worn, image: Tensor, source: Tensor, spot: Spot) -> Worn:
        """The wear of a frame that has changed within a spot since it was `worn`; as `of`, at less cost."""
        around, _ = widened(spot, _REACH, source[0].shape)
        wide, there = widened(around, _REACH, source[0].shape)
        smooth, bent, angle = worn.smooth.clone(), worn.bent.clone(), worn.angle.clone()
        known = torch.ones_like(source[0][wide], dtype=torch.bool)
        smooth[(slice(None), *around)] = blurred(image[(slice(None), *wide)], known, _BLUR)[(slice(None), *there)]
        part = source[(slice(None), *wide)]
        beside = turned(part)
        angle[around], bent[around] = angle_of(beside)[there], distortion(part, beside)[there]
        energy, touched = worn.energy.clone(), self._touched(around)
        energy[touched] = self._energy(smooth, source, angle, touched)
        there = self.reach(spot)
        change = self._spread(touched, energy[touched] - worn.energy[touched], there)
        wear = worn.wear.clone()
        wear[there] = wear[there] + change + self.area * (bent[there] - worn.bent[there])
        return Worn(wear, smooth, energy, bent, angle)

    def reach(self, spot: Spot) -> Spot:
        """Where the wear may differ of a frame that has changed within a spot."""
        return widened(spot, _REACH + max(self.grid.width), self._mass.shape)[0]

    def _spread(self, which: Tensor, energy: Tensor, spot: Spot) -> Tensor:
        """What some windows (n,) differ by, spread over their pixels, in variances: at a spot that holds them all."""
        return self._sum(which, energy / self.variance, spot) / self._mass[spot]

    def _sum(self, which: Tensor, values: Tensor, spot: Spot) -> Tensor:
        """The sum at a spot that holds some windows (n,) of these, each a value (n,) times the metric's falloff."""
        from flow.animation.carrying.loops import spread

        made = torch.empty([part.stop - part.start for part in spot], dtype=torch.float32)
        corners = self.grid.corners[which] - torch.tensor([part.start for part in spot])
        spread(len(made), *(v.contiguous() for v in (corners, values, self.source.metric.falloff[..., 0])), made)
        return made

    def _touched(self, spot: Spot) -> Tensor:
        """The windows (n,) that have a pixel in a spot."""
        corners, width = self.grid.corners, torch.tensor(self.grid.width)
        low = torch.tensor([part.start for part in spot])
        high = torch.tensor([part.stop for part in spot])
        return ((corners < high) & (corners + width > low)).all(1).nonzero()[:, 0]

    def _off_copy(self, pixels: Tensor, source: Tensor, angle: Tensor, corners: Tensor) -> Tensor:
        """Squared distance (n,) of windows at these corners (n, 2) to what the copies at their centers put there."""
        center = (corners + torch.tensor([w // 2 for w in self.grid.width])).T
        middle = source[(slice(None), *center)]
        there = middle.flip(0).round().long().T
        page = (there[:, 0] // self._film.pitch).clamp(0, self._film.pages - 1) * self._film.pitch
        first = torch.stack([page, torch.zeros_like(page)], 1)
        half = corners[:1] - center.T[:1]
        # pages are alike in what may be copied
        there = first + self.source.corners(self.source.snapped((there - first + half).clamp(max=self._last)))
        turn = angle[tuple(center)] * bool(self._film.turning)
        turn = torch.where(turn.abs() > _TURNED, turn, 0.0)
        return self._apart(pixels, corners, self._pixels, there, middle, turn)

    def _apart(
        self, pixels: Tensor, corners: Tensor, exemplar: Tensor, there: Tensor, middle: Tensor, turn: Tensor
    ) -> Tensor:
        """Squared distance (n,) of windows to an exemplar's; arguments as of `carrying.loops.compare`."""
        from flow.animation.carrying.loops import compare

        apart, given = torch.empty(len(corners), dtype=torch.float32), (pixels, corners, exemplar, there, middle, turn)
        compare(len(corners), *(v.contiguous() for v in (*given, self.source.metric.weight)), apart)
        return apart

    def _found(self, pixels: Tensor, corners: Tensor) -> Tensor:
        """Squared distance (n,) of windows at these corners (n, 2) to the nearest of the exemplar's."""
        windows = windows_at(pixels, corners, self.grid.width)
        found = self.source.nearest(self.source.projected(windows), 1, self._route)
        there = self.source.corners(found[:, 0])
        return self._apart(
            pixels, corners, self.source.pixels, there, there.T.float(), torch.zeros(len(there), dtype=torch.float32)
        )

    def _energy(self, image: Tensor, source: Tensor, angle: Tensor, which: Tensor) -> Tensor:
        """Squared distance (n,) of these windows to the nearest of what each copies and what the search finds."""
        pixels, corners = channels_last(image), self.grid.corners[which]
        energy = self._off_copy(pixels, source, angle, corners)
        worn = (energy > _SETTLED * self.variance).nonzero()[:, 0]
        if len(worn):
            energy[worn] = energy[worn].minimum(self._found(pixels, corners[worn]))
        return energy
