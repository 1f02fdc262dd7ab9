"""The output while it is made of patches: which patch each pixel comes from, and what the seams between them cost.

A patch is one source laid down at one offset, cut to a box. Laying it down (thesis section 3.1) solves one minimum cut
over the box: empty pixels must take the patch, filled ones may, fixed ones may not, and pixels around the box stay. Old
seams are remembered, so a patch that lands on filled ground mends those that it replaces by cheaper ones (surrounded
regions, 3.1.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any, Generic, TypeVar

import numpy as np

from kwatra.base.spans import volume
from kwatra.cut import FREE, MOST, TAKE
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array, SeamCost, Stock, summed
from kwatra.pieces.sheet.cuts import Cut, Cuts, Patch
from kwatra.pieces.sheet.window import Window, Windows

S = TypeVar("S", bound=Stock)

UNCOUNTED = np.empty(0)
"""How often places are shown where that is not counted."""


class Sheet(Generic[S]):
    """What is laid so far; arrays are indexed by output pixel.

    `label`: the patch of each pixel, an index into `patches`, -1 where empty. `places`: what it shows of the sources
    (see `Stock`). `seams`: per axis the remembered cost between a pixel and the next one. `fixed`: pixels that keep
    their patch. `total`: the sum of the seams.
    """

    def __init__(
        self,
        sources: S,
        shape: Sequence[int],
        periodic: Sequence[bool],
        cost: SeamCost,
    ):
        self.sources, self.cost = sources, cost
        self.shape, self.periodic = tuple(shape), tuple(periodic)
        self.label = np.full(self.shape, -1, np.int32)
        self.places = sources.nowhere(self.shape)
        self.seams = np.zeros((len(self.shape), *self.shape), np.int32)
        self.fixed = np.zeros(self.shape, bool)
        self.patches: list[Patch] = []
        self.total = 0

    def empty(self) -> Sheet[S]:
        """Another sheet for the same sources, on which nothing lies."""
        return Sheet(self.sources, self.shape, self.periodic, self.cost)

    def copy(self) -> Sheet[S]:
        """Another sheet that shows the same, of the same sources."""
        other = self.empty()
        other.label, other.places, other.seams = self.label.copy(), self.places.copy(), self.seams.copy()
        other.fixed, other.patches, other.total = self.fixed.copy(), [*self.patches], self.total
        return other

    def aside(self) -> Sheet[S]:
        """The same pixels, for patches that do not meet those that are laid on another such sheet meanwhile."""
        other = copy(self)
        other.patches = [*self.patches]
        return other

    def join(self, before: Sheet[S], behind: Sheet[S], axis: int, start: int) -> None:
        """Take over what was laid on two sheets `aside` since: on the second from a start on along an axis."""
        known = len(self.patches)
        label = self.label[(slice(None),) * axis + (slice(start, None),)]
        label[label >= known] += len(before.patches) - known
        self.patches = [*before.patches, *behind.patches[known:]]
        self.total = before.total + behind.total - self.total

    def clear(self, box: Box, keep: np.ndarray | None = None) -> None:
        """Take away what lies in a box, but for the pixels to keep (*shape), which leaves no seams of its own."""
        cleared = np.zeros(self.shape, bool)
        cleared[self.indices(box)] = True
        if keep is not None:
            cleared &= ~keep
        self.label[cleared], self.fixed[cleared] = -1, False
        for axis, seams in enumerate(self.seams):
            seams[cleared | np.roll(cleared, -1, axis)] = 0
        self.total = summed(self.seams)

    @property
    def filled(self) -> np.ndarray:
        """The pixels that have a patch."""
        return self.label >= 0

    def filled_at(self, at: tuple[Any, ...]) -> np.ndarray:
        """Which of some pixels (as `indices` gives them) have a patch."""
        there: np.ndarray = self.label[at] >= 0
        return there

    def full(self, box: Box) -> bool:
        """Whether all pixels of a box have a patch."""
        return bool(self.filled_at(self.indices(box)).all())

    def longest(self, axis: int) -> int:
        """The longest patch an axis admits: around a closed axis it must leave both its neighbors distinct."""
        return max(self.shape[axis] - 2, 1) if self.periodic[axis] else self.shape[axis]

    def indices(self, box: Box) -> tuple[Any, ...]:
        """The index of a box's pixels: slices, or an open mesh where it passes the border, on axes that wrap."""
        lines = list(zip(box.start, box.stop, self.shape, strict=True))
        if all(0 <= start <= stop <= n for start, stop, n in lines):
            return tuple(slice(start, stop) for start, stop, _ in lines)
        return np.ix_(*[np.arange(start, stop) % n for start, stop, n in lines])

    def lay(
        self,
        patch: Patch,
        *,
        must: np.ndarray | None = None,
        must_not: np.ndarray | None = None,
        taking: np.ndarray | None = None,
        cheaper: bool = False,
    ) -> bool:
        """Cut a patch into the sheet; True if it changed anything. As `cut`.

        With `cheaper` the patch is only accepted if its price is below 0: if the seams, and what taking costs, fall.
        """
        cut = self.cut_below(-1 if cheaper else MOST, patch, must=must, must_not=must_not, taking=taking)
        if cut is None or not cut.take.any():
            return False
        self.commit(cut)
        return True

    def windows(self, boxes: Sequence[Box]) -> Windows:
        """What there is to cut patches into that lie within each of boxes."""
        wide = (Box(tuple(s - 1 for s in box.start), tuple(e + 2 for e in box.extent)) for box in boxes)
        around = [box.clipped(self.shape, self.periodic) for box in wide]
        return Windows.of(around, self.label, self.places, self.fixed, self.seams)

    def cut(
        self,
        patch: Patch,
        *,
        must: np.ndarray | None = None,
        must_not: np.ndarray | None = None,
        taking: np.ndarray | None = None,
    ) -> Cut:
        """The cheapest way to cut a patch in.

        Arrays over the patch's box: `must`, `must_not`: booleans, pixels that have to take it or may not. `taking`:
        what a filled pixel costs more when it takes the patch, in the units of the seams, whole numbers.
        """
        cut = self.cut_below(MOST, patch, must=must, must_not=must_not, taking=taking)
        assert cut is not None
        return cut

    def cut_below(
        self,
        most: int,
        patch: Patch,
        *,
        must: np.ndarray | None = None,
        must_not: np.ndarray | None = None,
        taking: np.ndarray | None = None,
        window: Window | None = None,
    ) -> Cut | None:
        """As `cut`, or None if its price is above `most`: many a cut need not be solved for that to be known.

        window: of a box in which the patch's lies, as it is now, where several patches are tried on it.
        """
        window = self.windows([patch.box])[0] if window is None else window
        if taking is None and -window.total > most:  # were no seam left
            return None
        inner = window.box.part(patch.box)
        choice = _choice(window, inner, must, must_not)
        new = self.patch_places(patch, window.box)
        extra = None
        if taking is not None:
            extra = np.zeros(choice.shape, np.int64)
            extra[inner] = taking
        cut = self.cost.cut(window.places, new, window.remembered, choice, extra, most)
        if cut is None:
            return None
        take, seams = cut
        change = summed(seams) - window.total
        price = change + (0 if extra is None else int(extra[take & (choice == FREE)].sum()))
        return Cut(patch, window, take, new, seams, change, price) if price <= most else None

    def commit(self, cut: Cut) -> None:
        """Lay a patch as it was cut; nothing may have been laid in between."""
        self.commit_each([Cuts.of(cut)], [(0, 0)])

    def commit_each(self, cuts: Sequence[Cuts], order: Sequence[tuple[int, int]], shown: Array = UNCOUNTED) -> None:
        """Lay patches as they were cut, so that none meets another, in an order: of which cuts, and which of these.

        shown (*cell): how often each place of a mosaic is, counted anew.
        """
        from kwatra.pieces.sheet.pixels import lay_each

        numbers, axes = [np.full(len(some), -1) for some in cuts], len(self.shape)
        for group, at in order:
            patch = cuts[group].patches[at]
            assert patch is not None
            numbers[group][at] = len(self.patches)
            self.patches.append(patch)
            self.total += int(cuts[group].changes[at])
        sheet = volume(self.label, axes), self._numbers(self.places), volume(self.seams, axes)
        for some, each in zip(cuts, numbers, strict=True):
            lay_each(*sheet, some.windows.pixels, each, some.take, some.places, some.seams, shown.reshape(-1))

    def _numbers(self, places: Array) -> Array:
        """Places (..., *E) as so many numbers for each pixel of a volume (k, *E)."""
        axes = len(self.shape)
        return volume(places.reshape(-1, *places.shape[places.ndim - axes :]), axes)

    def patch_places(self, patch: Patch, window: Box) -> np.ndarray:
        """The places a box shows of a patch's source, which goes on beyond the patch by one pixel, and by its rim."""
        steps = zip(window.start, window.stop, patch.box.start, patch.box.stop, patch.shift, strict=True)
        lines = [
            np.minimum(np.maximum(np.arange(low, high), first - 1), last) - shift
            for low, high, first, last, shift in steps
        ]
        return self.sources.places(patch.number, lines)


def _choice(
    window: Window, inner: tuple[slice, ...], must: np.ndarray | None, must_not: np.ndarray | None
) -> np.ndarray:
    """What may happen to a window's pixels where a patch is cut in within `inner`."""
    choice, core = window.kept.copy(), window.laid[inner].copy()
    free = ~window.fixed[inner]
    if must is not None:
        core[must & free] = TAKE
    if must_not is not None:
        core[must_not & free] = window.kept[inner][must_not & free]
    choice[inner] = core
    return choice
