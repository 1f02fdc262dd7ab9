"""Worn texture is renewed: what is left of the energy's minimization for a frame that was carried along.

A frame carried along is x+, the best there is for the flow term (x - x+)^T K (x - x+) (thesis equation 27). What it
loses is texture: copies of the exemplar are bent, what they show goes out of proportion, and where they meet they
cease to agree. So the texture energy (thesis equation 18) is measured, window by window; where it is highest, blocks
of the exemplar are found that come closest to what is there; and of each block (where gaps between elements hide seams
of what is around it as well, so that it may end in a gap) those pixels are taken that lower

    U = sum_p max(wear(p) + tone(p) - tolerance, 0) + age(p) + lambda sum_p K(p) |x(p) - x+(p)|^2 + seams,

by a minimum cut (a fusion of two labelings: Lempitsky, Rother, Roth and Blake 2010) in which old seams are remembered,
so that a block may mend them. A seam costs what its copies differ by on both of its sides (thesis equation 1), and
where the exemplar has gaps between elements more if it does not run along them; wear and tone count where something
has moved, and everything in variances of the exemplar.

The cut has to guess the wear that a new copy will have: none in the block's middle, and toward its rim, where windows
reach across, more and more what was there. So U is measured before and after, and a block that does not lower it is
not laid. Only what is lost, beyond the exemplar's border, is replaced whatever that costs. Windows are copied, never
averaged, so nothing blurs; and a pixel changes only where that buys more texture than it costs in motion.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from flow.animation.carrying import angle_of, parted, softened, turned
from flow.animation.film import Film, Reading, nearest_pixels, where_inside
from flow.animation.renewing.aging import Aging
from flow.animation.renewing.blocks import Blocks, bell, inner, side_of
from flow.animation.renewing.fibers import block_sides
from flow.animation.renewing.needs import neediest
from flow.animation.renewing.placing import Spot, bounds, reach, settled, shift_of, taken_by, turn_of, upright, widened
from flow.animation.renewing.scenes import home_of
from flow.animation.renewing.stock import COUNTS, Coordinates, counted
from flow.animation.renewing.tones import Tones
from flow.animation.renewing.wear import Wear, Worn
from flow.animation.settings import Renewing
from flow.animation.term import gradient_weight
from kwatra.base import mean, over_channels, total
from kwatra.cut import along
from kwatra.elements import anisotropy, easier
from kwatra.pieces import Box, Patch, Sheet

_BEYOND, _UNSURE = 1 / 4, 0.1
"""Where gaps hide seams, by so much of its side a block may go on, and what a pixel costs there, and less in its rim.
Of made stones of 20 and 32 px in a pair of vortices .35 are cut so, .44 by blocks that end at their borders, with
twice as many straight seams through stones; motion of these, of larger stones and of nuts is off by .193 px and .196.
With half a side a tenth fewer are cut, at a fourth more cost; if that costs nothing a fourth fewer, but a fifth more is
renewed, and motion is off by .214 px."""

_PROMISE = 0.1
"""A block is measured only if its cut promises to save so much of the wear that is there. In 30 frames of bricks and
radishes in a pair of vortices, and of nuts that turn, this leaves out 24 to 44 percent of the blocks that would not
have been laid, and .5 to 1.5 percent of all that others save; .2 would leave out 45 to 69, and .7 to 7."""

_BEFORE = ((-1, 0), (0, -1))
"""The steps, in rows and columns, to the pixels before one along the axes."""

_ALL = (slice(None), slice(None))


@dataclass
class Carried:
    """A frame at work.

    image (C, H, W): what it shows; carried: what it showed at first, x+; weight (H, W): lambda K. sheet: its source
    coordinates and seams; what is not usable of it, or not inside (H, W), is empty there. counts (H, W): where wear
    counts. worn: its wear; prices: what each tone costs; costs (2, H, W): what pixels cost by their tones and by age.
    left (H, W): how worn tries of blocks left what is there, on average over a block; None for videos, of which other
    blocks are found in each frame. place (2, H, W): where pixels of a scene belong (`scenes`), or None.
    """

    image: Tensor
    carried: Tensor
    weight: Tensor
    sheet: Sheet[Coordinates]
    inside: Tensor
    counts: Tensor
    worn: Worn
    prices: Tensor
    costs: Tensor
    left: Tensor | None
    place: Tensor | None

    @property
    def source(self) -> Tensor:
        """The source coordinates (2, H, W), x first; they share the sheet's memory."""
        return torch.from_numpy(self.sheet.places[:2])

    @property
    def usable(self) -> Tensor:
        """Where (H, W) there is texture."""
        return torch.from_numpy(self.sheet.filled)


class Renewed(NamedTuple):
    """A frame that was renewed: its source coordinates (2, H, W), image (C, H, W), and what that took.

    left (H, W): how worn blocks were left, on average, that were tried in this frame or before; 0 where none was, None
    for videos. report: what `Frame` says.
    """

    source: Tensor
    image: Tensor
    left: Tensor | None
    report: dict[str, float]


class Renewal:
    """Renews frames of `shape` (H, W) with texture from an exemplar.

    whole: whether elements are drawn whole anyway, so that blocks need hold none.
    """

    def __init__(self, film: Film, shape: tuple[int, int], settings: Renewing, whole: bool = False) -> None:
        self.film, self.shape, self.settings = film, shape, settings
        exemplar = film.described
        self.wear = Wear(film, shape, settings.window, settings.step, settings.area)
        self.tones = Tones(film.strip, settings.tones, film.grain, film.pages)
        self.aging = Aging(film, settings.aging)
        self.read = Reading(exemplar, settings.interpolation)
        hidden = film.hidden
        size = min(side_of(settings.block, None if whole else hidden), *shape)
        self.blocks = Blocks(film, block_sides(size, film.along, shape), hidden)
        sides = self.blocks.sides
        self._beyond, self._unsure = (0, 0.0) if hidden is None else (round(_BEYOND * sides[0]), _UNSURE)
        self._share = exemplar.share
        self.stock = Coordinates(exemplar, self.wear.variance, settings.seam)
        self._seams = self.stock.whole(hidden, easier(anisotropy(film.strip), film.along))
        self._bell, self._inner = bell(sides), inner(sides)

    def __call__(
        self,
        source: Tensor,
        inside: Tensor,
        generator: torch.Generator,
        moved: Tensor | None = None,
        left: Tensor | None = None,
        place: Tensor | None = None,
    ) -> Renewed:
        """Renew a carried frame, given by its source coordinates (2, H, W).

        inside (H, W): True where texture belongs; elsewhere coordinates are left alone. generator: chooses what enters
        where there is nothing to agree with. moved (H, W): where texture can have worn at all (default: everywhere).
        left (H, W): `Renewed.left` of the frame before, carried along (default: nothing was tried). place (2, H, W):
        where in a scene pixels belong (default: anywhere).
        """
        frame, sides, most = self.begin(source, inside, moved, left, place), self.blocks.sides, self.settings.blocks
        worn, lost = self._worn(frame, frame.worn.wear, frame.costs), inside & self.read.lost(source)
        usable = frame.usable
        self._renew(frame, neediest(worn, lost, frame.left, sides, most), generator)
        while bool((lost := lost & ~frame.usable).any()):
            self._renew(frame, neediest(torch.zeros_like(worn), lost, frame.left, sides, most), generator)
        after = frame.source
        changed = usable & (after != source).any(0)
        area = total(inside.float()).clamp(min=1)
        report = {
            "texture": float(total(worn) / area),
            "flow": float(total(self._flow(frame, frame.image) * usable) / area),
            "renewed": float(total(changed.float()) / area),
        }
        return Renewed(after.clone(), softened(frame.image, after, inside, self.read), frame.left, report)

    def begin(
        self,
        source: Tensor,
        inside: Tensor,
        moved: Tensor | None = None,
        left: Tensor | None = None,
        place: Tensor | None = None,
    ) -> Carried:
        """A carried frame ready for renewal; arguments as of a call."""
        usable = inside & self.read.usable(source)
        image = self.read(source)
        sheet = Sheet(self.stock, self.shape, (False, False), self._seams)
        beside = turned(source, usable)
        sheet.places[:] = torch.cat([source, angle_of(beside)[None]]).numpy()
        sheet.label[usable.numpy()] = 0
        seams, _ = parted(source, usable, beside, _BEFORE)
        for axis, seam in enumerate(seams.numpy()):
            p, q = along(axis, None, -1, 2), along(axis, 1, None, 2)
            jump = seam[q]
            one, other = (sheet.places[(slice(None), *side)][:, jump] for side in (p, q))
            sheet.seams[axis][p][jump] = sheet.cost.seam(one, other, axis, 2)
        sheet.total = int(sheet.seams.sum(dtype=np.int64))
        weight = self.settings.flow_weight * gradient_weight(image, self._share)
        counts = usable if moved is None else usable & moved
        shown = self.tones.of(source)
        prices = self.tones.prices(shown, usable)
        worn, costs = self.wear.of(image, source), torch.stack([prices[shown], self.aging.of(source)])
        if self.film.motion is None:
            left = torch.zeros_like(image[0]) if left is None else left.clone()
        return Carried(image.clone(), image, weight, sheet, inside, counts, worn, prices, costs, left, place)

    def _costs(self, prices: Tensor, source: Tensor) -> Tensor:
        """What pixels that show source (2, *S) cost by their tones, at these prices, and by age: (2, *S)."""
        return torch.stack([prices[self.tones.of(source)], self.aging.of(source)])

    def _worn(self, frame: Carried, wear: Tensor, costs: Tensor, spot: Spot = _ALL) -> Tensor:
        """U's first sum, pixel by pixel, where wear (h, w) and costs (2, h, w) are those at a spot."""
        return ((wear + costs[0] - self.settings.tolerance).clamp(min=0) + costs[1]) * frame.counts[spot]

    def _flow(self, frame: Carried, image: Tensor, spot: Spot = _ALL) -> Tensor:
        """U's second sum, pixel by pixel: what an image (C, h, w) costs at a spot of the frame."""
        change = (image - frame.carried[(slice(None), *spot)]).square() * self._share
        return frame.weight[spot] * over_channels(change) / self.wear.variance

    def _renew(self, frame: Carried, places: list[tuple[int, int]], generator: torch.Generator) -> None:
        """Find a block for each place and take of it what lowers the energy."""
        if not places:
            return
        height, width = self.blocks.sides
        spots = [(slice(row, row + height), slice(column, column + width)) for row, column in places]
        turns = [self._turn(frame, spot) for spot in spots]
        image = self.blocks.seen(frame.image, frame.source)
        seen = [upright(image, frame.usable, spot, turn) for spot, turn in zip(spots, turns, strict=True)]
        content, known = torch.stack([part for part, _ in seen]), torch.stack([there * self._bell for _, there in seen])
        homes, more = [self._home(frame, spot) for spot in spots], [reach(height, turn) for turn in turns]
        corners = self.blocks.nearest(content, known[:, None], self._using(frame), generator, homes, more)
        for spot, turn, corner in zip(spots, turns, corners, strict=True):
            patch = Patch(turn, shift_of(corner, spot, turn), Box((spot[0].start, spot[1].start), (height, width)))
            self._fuse(frame, self._in_place(frame, spot, patch), spot)
            if frame.left is not None:
                here = frame.costs[(slice(None), *spot)]
                frame.left[spot] = mean(self._worn(frame, frame.worn.wear[spot], here, spot)).float()

    def _turn(self, frame: Carried, spot: Spot) -> int:
        """The source that is turned as copies of a spot are, if they may be and the exemplar holds such blocks."""
        turn = turn_of(frame.worn.angle[spot], frame.usable[spot]) if self.film.turning else 0
        return turn if self.blocks.holds(reach(self.blocks.sides[0], turn)) else 0

    def _home(self, frame: Carried, spot: Spot) -> Tensor | None:
        """The corner (2,) of the block that belongs to a spot; None where texture is missing or places tell nothing."""
        return None if frame.place is None or not bool(frame.usable[spot].all()) else home_of(frame.place, spot)

    def _in_place(self, frame: Carried, spot: Spot, patch: Patch) -> Patch:
        """A block moved to where the copy is that it was found again for, if it then lies in the exemplar."""
        shift = settled(patch, frame.source[(slice(None), *spot)] - self._shown(patch, spot), frame.usable[spot])
        moved = replace(patch, shift=shift)
        return moved if bool(self.read.usable(self._shown(moved, spot)).all()) else patch

    def _shown(self, patch: Patch, spot: Spot) -> Tensor:
        """The source coordinates (2, h, w) that a block shows at a spot."""
        lines = [np.arange(part.start, part.stop) - by for part, by in zip(spot, patch.shift, strict=True)]
        return torch.from_numpy(self.stock.places(patch.number, lines)[:2])

    def _using(self, frame: Carried) -> Callable[[Tensor], Tensor]:
        """What using each exemplar pixel of some rows (r,) once more costs, (r, W).

        By how much its place is used already, in whatever frame, by its tone, and by how soon it cannot live on.
        """
        height, width = self.film.strip.shape
        row, column = nearest_pixels(frame.source, (height, width))
        place = where_inside(row % self.film.pitch * width + column, frame.inside)
        used = torch.bincount(place, minlength=self.film.pitch * width).view(-1, width).float()
        usage = self.settings.usage * used / mean(used).clamp(min=1e-6)
        return lambda rows: (
            self.wear.variance
            * (usage[rows % self.film.pitch] + self.tones.costs(frame.prices, rows) + self.aging.costs(rows))
        )

    def _fuse(self, frame: Carried, patch: Patch, block: Spot) -> None:
        """Take of a block the pixels that lower the energy, as the cut guesses; and only if, measured, they do."""
        spot, part = widened(block, self._beyond, self.shape)
        here, sure = (slice(None), *spot), torch.zeros_like(frame.weight[spot])
        sure[part] = self._inner
        patch = replace(patch, box=Box((spot[0].start, spot[1].start), (sure.shape[0], sure.shape[1])))
        source = self._shown(patch, spot)
        new, old = self.read(source), frame.image[here]
        costs = self._costs(frame.prices, source)
        worn = self._worn(frame, frame.worn.wear[spot], frame.costs[here], spot)
        fresh = self._worn(frame, torch.zeros_like(worn), costs, spot)
        change = self._flow(frame, new, spot) - self._flow(frame, old, spot)
        taking = change + (fresh - worn) * sure + self._unsure * (1 - sure)
        may = frame.inside[spot] & self.read.joined(source)
        cut = frame.sheet.cut(patch, must_not=~may.numpy(), taking=counted(taking.numpy()))
        take = taken_by(cut)
        lost = bool((take & ~frame.usable[spot]).any())
        if not lost and -cut.price <= _PROMISE * float(total(worn[part])) * COUNTS:
            return
        image, places, priced = (values.clone() for values in (frame.image, frame.source, frame.costs))
        for values, taken in ((image, new), (places, source), (priced, costs)):
            values[here] = torch.where(take, taken, values[here])
        changed = bounds(take, spot)
        after = self.wear.after(frame.worn, image, places, changed)
        wide = self.wear.reach(changed)
        before = total(self._worn(frame, frame.worn.wear[wide], frame.costs[(slice(None), *wide)], wide))
        gained = total(self._worn(frame, after.wear[wide], priced[(slice(None), *wide)], wide)) - before
        gained = gained + total(change * take * frame.usable[spot])
        if lost or float(gained) + cut.change / COUNTS < 0:
            frame.sheet.commit(cut)
            frame.image, frame.worn, frame.costs = image, after, priced
