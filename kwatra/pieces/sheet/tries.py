"""Several patches tried on one window, and the one that is laid at the least cost, in one compiled call.

It holds no lock of the interpreter's, so threads can share the patches, or lay on several windows side by side. Pixels
are seen as (before, rows, columns), whatever their axes.

This module is compiled by numba when first used, so it is imported where patches are tried.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from kwatra.base import shared, threads_shared
from kwatra.base.compiled import jitted
from kwatra.base.spanloops import widened
from kwatra.base.spans import volume
from kwatra.cut.choices import FREE, MOST, TAKE
from kwatra.cut.network import sides
from kwatra.pieces.loops import copy_into, patch_sides
from kwatra.pieces.seams import Array, Prices
from kwatra.pieces.seams.matches import cut_places

Item = TypeVar("Item")


class Tries(NamedTuple):
    """Patches (n,) of a mosaic's first source, tried on a window.

    Each is all that a box shows of the source. shifts (n, axes): by how much that is shifted, counted from the window's
    first pixel; bounds (3, axes): its size, where the box begins, and where it has ended, counted as well. costs (n,):
    what each costs beside its price; rates (n,): what its price counts. must: whether all of a patch is taken. taking
    (n, pixels): what pixels cost more when they take a patch, as in `Sheet.cut`; (0, 0) for nothing.
    """

    shifts: Array
    bounds: Array
    costs: Array
    rates: Array
    must: bool
    taking: Array


class Ground(NamedTuple):
    """What patches are laid on, and of: arrays of a window (`Window`), colors by place (C, N) and what places mean.

    owned (N,): which places are shown at all, of none where all are. strides (axes,): from a place to the next. prices:
    what seams cost there.
    """

    kept: Array
    laid: Array
    fixed: Array
    places: Array
    remembered: Sequence[Array]
    total: int
    planes: Array
    owned: Array
    strides: Sequence[int]
    prices: Prices


Offered = tuple[Tries, Ground, float]
"""What is tried, on what, and what it has to cost less than."""


class Found(NamedTuple):
    """The number of the patch that costs least, and what it costs; the rest is as in `Cut`."""

    number: int
    cost: float
    take: Array
    places: Array
    seams: list[Array]
    change: int
    price: int


def cheapest_of(groups: Sequence[Item], offered: Callable[[Item], Sequence[Offered]]) -> list[Found | None]:
    """Of each offer the patch whose cost, and price times rate, come to least; None if none comes to less than a bound.

    Of equals it is the first. What is offered of a group is told when a thread begins with it, of one alone before.
    Threads share the groups; who finds all begun helps with the last offers, patch by patch, knowing what has been
    found: a cut that costs more need not be solved. They come in the order of groups, and of what is offered of each.
    """

    def contests_of(group: Item) -> list[_Contest]:
        return [_Contest(*offer) for offer in offered(group)]

    begun = [[one] for one in contests_of(groups[0])] if len(groups) == 1 else [list[_Contest]() for _ in groups]

    def begin(number: int) -> None:
        begun[number] = begun[number] or contests_of(groups[number])
        for contest in begun[number]:
            contest.join()

    def help_with(number: int) -> None:
        for contest in reversed(begun[number]):
            contest.join()

    order, helpers = range(len(begun)), threads_shared() - 1
    work = [*(partial(begin, n) for n in order), *(partial(help_with, n) for n in [*reversed(order)] * helpers)]
    shared(lambda each: each(), work)
    return [contest.best for contests in begun for contest in contests]


class _Contest:
    """Patches that are tried on a window, and the best of them that any thread has found."""

    def __init__(self, tries: Tries, ground: Ground, least: float) -> None:
        self._offer = tries, ground, least
        self._lowest, self._following = np.array([least]), np.zeros(1, np.int64)
        self._found = list[Found]()

    def join(self) -> None:
        """Try patches until all have been begun with."""
        if self._following[0] < len(self._offer[0].costs):
            found = _cheapest_of(*self._offer, self._lowest, self._following)
            if found is not None:
                self._found.append(found)

    @property
    def best(self) -> Found | None:
        """The cheapest of what was found, of equals the first."""
        return min(self._found, key=lambda one: (one.cost, one.number), default=None)


def _cheapest_of(tries: Tries, ground: Ground, least: float, lowest: Array, following: Array) -> Found | None:
    """The same of the patches that no other thread has begun with.

    lowest, following (1,): the least that any thread has found so far, and the patch to be tried next.
    """
    shape, axes, strides = ground.kept.shape, ground.kept.ndim, np.array(ground.strides)
    take, places = np.empty(shape, np.bool_), np.empty_like(ground.places)
    seams = [np.empty(cost.shape, np.int32) for cost in ground.remembered]
    a, left = (sides(costs, take.size) for costs in (ground.remembered, seams))
    number, cost, change, price = _try_every(
        volume(ground.kept, axes), volume(ground.laid, axes), volume(ground.fixed, axes), volume(ground.places, axes),
        a, ground.total, ground.planes, ground.owned, strides, ground.prices, tries.shifts, tries.bounds, tries.costs,
        tries.rates, tries.must, tries.taking, least, lowest, following, take.ravel(), places.ravel(), left,
    )  # fmt: skip
    return None if number < 0 else Found(number, cost, take, places, seams, change, price)


@jitted
def _try_every(
    kept: Any, laid: Any, fixed: Any, old: Any, a: Any, total: Any, planes: Any, owned: Any, strides: Any, prices: Any,
    shifts: Any, bounds: Any, costs: Any, rates: Any, must: Any, taking: Any, least: Any, lowest: Any, following: Any,
    take: Any, places: Any, left: Any,
) -> Any:  # fmt: skip
    """The number of the cheapest try, -1 for none, what it costs, its change and price.

    Sets what it takes and shows, and along each axis the seams that are left with it. Threads that ask for the next at
    once may try the same, but leave none out: a number is written only where the one before it was taken. Which tries
    are given up depends on what other threads have found by then, but none that is as cheap is: `most` is rounded up.
    """
    count, best, best_change, best_price = kept.size, -1, 0, 0
    choice, new, taken = np.empty(kept.shape, np.int8), np.empty(old.shape, old.dtype), np.empty(count, np.bool_)
    weight = np.zeros(count, np.int64)
    shown_old, shown_new, may, without = old.ravel(), new.ravel(), choice.ravel(), kept.ravel()
    b, c, tried = _like(a), _like(a), _like(a)
    starts, stops = patch_sides(shifts, bounds)
    # a plane that is none begins before any place of the source
    shift, size, stride = widened(shifts, 1), widened(bounds[:1], 1)[0], widened(strides.reshape((1, -1)), 0)[0]
    while following[0] < len(costs):
        k = following[0]
        following[0] = k + 1
        most = MOST if lowest[0] == np.inf else math.ceil((lowest[0] - costs[k]) / rates[k])
        if len(taking) == 0 and -total > most:  # were no seam left
            continue
        _lay_out(kept, laid, fixed, starts[k], stops[k], must, choice)
        _find_places(size, shift[k], starts[k], stops[k], new)
        if len(owned) > 0:
            for i in range(count):
                may[i] = may[i] if owned[shown_new[i]] else without[i]
        for i in range(count):
            weight[i] = taking[k, i] if len(taking) > 0 else 0
        if not cut_places(planes, stride, shown_old, shown_new, prices, may, weight, a, b, c, most, taken, tried):
            continue
        change = -total
        for axis in range(len(a)):
            change += tried[axis].sum()
        price = change
        if len(taking) > 0:
            for i in range(count):
                price += taking[k, i] if taken[i] and may[i] == FREE else 0
        cost = costs[k] + rates[k] * price
        if cost < least:
            least, best, best_change, best_price = cost, k, change, price
            lowest[0] = min(lowest[0], cost)
            copy_into(taken, take)
            copy_into(shown_new, places)
            for axis in range(len(a)):
                copy_into(tried[axis].ravel(), left[axis].ravel())
    return best, least, best_change, best_price


@jitted
def _like(costs: Any) -> Any:
    """Room for as many costs along each of three axes."""
    first, second, third = costs
    return np.empty(first.shape, np.int32), np.empty(second.shape, np.int32), np.empty(third.shape, np.int32)


@jitted
def _lay_out(kept: Any, laid: Any, fixed: Any, start: Any, stop: Any, must: Any, choice: Any) -> None:
    """What may happen to pixels where a patch is laid from start to before stop."""
    copy_into(kept.ravel(), choice.ravel())
    for i in range(start[0], stop[0]):
        for j in range(start[1], stop[1]):
            for k in range(start[2], stop[2]):
                choice[i, j, k] = TAKE if must and not fixed[i, j, k] else laid[i, j, k]


@jitted
def _find_places(sizes: Any, shift: Any, start: Any, stop: Any, places: Any) -> None:
    """The places a window shows of a shifted source, which goes on beyond the patch by one pixel, and by its rim."""
    for i in range(places.shape[0]):
        plane = _line(i, start[0], stop[0], shift[0], sizes[0]) * (sizes[1] + 2)
        for j in range(places.shape[1]):
            row = (plane + _line(j, start[1], stop[1], shift[1], sizes[1])) * (sizes[2] + 2)
            for k in range(places.shape[2]):
                places[i, j, k] = row + _line(k, start[2], stop[2], shift[2], sizes[2])


@jitted
def _line(at: Any, start: Any, stop: Any, shift: Any, size: Any) -> Any:
    """How far along an axis of the mosaic a pixel's place lies."""
    return min(max(min(max(at, start - 1), stop) - shift, -1), size) + 1
