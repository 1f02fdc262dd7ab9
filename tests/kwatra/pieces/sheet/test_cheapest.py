"""What is offered of groups, and cut in where it costs least."""

import numpy as np
import pytest
import torch

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams.cost import Depth, SeamCost, eased, normalized
from kwatra.pieces.seams.mosaic import Mosaic, by_place
from kwatra.pieces.sheet import Offer, Patch, Sheet, cheapest_as_offered, cheapest_cuts


def _two_copies(shape, seams, rng):
    """A sheet that shows two copies of a random source, shifted by two pixels, and seams of some kind between them."""
    source, axes = tuple(n - 2 for n in shape), len(shape)
    sources = Mosaic([rng.random((2, *source), np.float32)])
    depth = Depth(by_place(rng.random(source, np.float32)).__getitem__, 100.0)
    costs_of = {
        "plain": SeamCost(sources),
        "hidden": SeamCost(sources, depth=depth),
        "eased": eased(sources, [1, 9, 3]),
        "normalized": normalized(sources),
    }
    sheet = Sheet(sources, shape, (False,) * axes, costs_of[seams])
    sheet.lay(Patch(0, (0,) * axes, Box((0,) * axes, source)))
    sheet.lay(Patch(0, (2,) * axes, Box((2,) * axes, source)))
    return sheet


@pytest.mark.parametrize("shape", [(14, 15), (5, 9, 8)])
@pytest.mark.parametrize("seams", ["plain", "hidden", "eased", "normalized"])
@pytest.mark.parametrize("priced", [False, True])
@pytest.mark.parametrize(("slow", "threads"), [(False, 1), (False, 3), (True, 1)])
def test_of_several_patches_the_one_is_cut_in_that_costs_least(shape, seams, priced, slow, threads, monkeypatch):
    """Against each cut in alone; also by threads, and where cuts are too large to be solved at once."""
    torch.set_num_threads(threads)
    monkeypatch.setattr("kwatra.pieces.sheet.cheapest.solved_at_once", lambda choice: not slow)
    rng, axes = np.random.default_rng(0), len(shape)
    source, sheet = tuple(n - 2 for n in shape), _two_copies(shape, seams, rng)
    shifts = [(1,) * axes, (2, 1, 0)[:axes], (0, 2, 1)[:axes], (1, 0, 2)[:axes]]
    box = Box((1,) * axes, tuple(n - 1 for n in source))
    patches = [Patch(0, shift, box.within(Box(shift, source))) for shift in shifts]
    taking = [rng.integers(-900, 900, patch.box.extent) for patch in patches] if priced else []
    windows = sheet.windows([Box((0,) * axes, shape)] * 2)
    for costs, rates in (
        (np.zeros(4), np.ones(4)),
        (np.array([3.0, 0.5, 2.0, 1.0]), np.array([2e-5, 1e-4, 1e-5, 3e-5])),
    ):
        cuts = [sheet.cut(p, taking=taking[k] if priced else None) for k, p in enumerate(patches)]
        worth = [cost + rate * cut.price for cut, cost, rate in zip(cuts, costs, rates, strict=True)]
        best = int(np.argmin(worth))
        equal = np.array([*shifts, *shifts])  # of equals the first is taken
        one, firsts = sheet.windows(windows.boxes[:1]), np.array([0, 4])
        dearer = Offer(one, [box], firsts, np.array(shifts), costs, rates, min(worth), taking=taking)
        assert [*cheapest_cuts(sheet, dearer)] == [None]
        firsts, many = np.array([0, 8, 12]), (np.tile(costs, 3), np.tile(rates, 3), np.inf)
        both = Offer(windows, [box] * 2, firsts, np.array([*equal, *shifts]), *many, taking=taking * 3)
        found, again = cheapest_cuts(sheet, both)
        assert (again.patch, again.change, again.price) == (found.patch, found.change, found.price)
        assert found.patch == patches[best]
        assert (found.change, found.price) == (cuts[best].change, cuts[best].price)
        inner = tuple(
            slice(max(s - 1, 0), e + 1) for s, e in zip(patches[best].box.start, patches[best].box.stop, strict=True)
        )
        np.testing.assert_array_equal(found.take[inner], cuts[best].take)
        np.testing.assert_array_equal(found.places[inner][cuts[best].take], cuts[best].places[cuts[best].take])
    first = np.array([0, 1]), np.array(shifts[:1]), costs[:1], rates[:1]
    must = Offer(sheet.windows(windows.boxes[:1]), [box], *first, np.inf, must=True, taking=taking[:1])
    (whole,) = cheapest_cuts(sheet, must)
    assert int(whole.take.sum()) == np.prod(patches[0].box.extent)


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("large", [lambda laid: False, lambda laid: True, lambda laid: laid.shape[0] > 10])
def test_it_is_the_same_however_offers_are_grouped(threads, large, monkeypatch):
    torch.set_num_threads(threads)
    monkeypatch.setattr("kwatra.pieces.sheet.cheapest.solved_at_once", lambda laid: not large(laid))
    rng = np.random.default_rng(0)
    sources = Mosaic([rng.random((2, 20, 20), np.float32)])
    sheet = Sheet(sources, (40, 40), (False, False), SeamCost(sources))
    for corner in ((0, 0), (0, 20), (20, 0), (20, 20)):
        sheet.lay(Patch(0, corner, Box(corner, (20, 20))))
    boxes = [Box((8 + 3 * k, 9 + 2 * k), (8 + k % 3, 9)) for k in range(6)]
    counts, of_all = [5, 1, 5, 4, 5, 2], list[tuple[Box, np.ndarray, np.ndarray]]()
    for box, count in zip(boxes, counts, strict=True):
        of_all.append((box, np.array(box.start) - rng.integers(0, 10, (count, 2)), rng.random(count)))

    def offer(some: list[int]) -> Offer:
        told = [of_all[number] for number in some]
        firsts = np.cumsum([0, *(len(shifts) for _, shifts, _ in told)])
        shifts, costs = (np.concatenate([one[part] for one in told]) for part in (1, 2))
        windows = sheet.windows([box for box, _, _ in told])
        return Offer(windows, [box for box, _, _ in told], firsts, shifts, costs, np.full(len(costs), 1e-4), np.inf)

    groups, asked = [[0], [1, 2, 3], [4, 5]], list[int]()

    def of_group(group: int) -> Offer:
        asked.append(group)
        return offer(groups[group])

    alone = [cheapest_cuts(sheet, offer([number]))[0] for number in range(6)]
    together = cheapest_cuts(sheet, offer([*range(6)]))
    one_by_one = [cut for cuts in cheapest_as_offered(sheet, range(3), of_group) for cut in cuts]
    for found in (together, one_by_one):
        for one, other in zip(alone, found, strict=True):
            assert (one.patch, one.change, one.price) == (other.patch, other.change, other.price)
            np.testing.assert_array_equal(one.take, other.take)
            np.testing.assert_array_equal(one.places[one.take], other.places[one.take])
    assert sorted(asked) == [0, 1, 2]
    assert len({one.patch.shift for one in alone}) > 3


def test_cuts_laid_together_are_what_they_are_laid_one_by_one() -> None:
    rng = np.random.default_rng(3)
    sources = Mosaic([rng.random((2, 20, 20), np.float32)])
    sheets = [Sheet(sources, (40, 40), (False, True), SeamCost(sources)) for _ in range(2)]
    for sheet in sheets:
        sheet.lay(Patch(0, (5, 5), Box((5, 5), (20, 20))))
    boxes, shifts = (
        [Box((2, 3), (9, 9)), Box((20, 36), (12, 9)), Box((20, 15), (9, 11))],
        np.array([[0, 1], [18, 35], [16, 9]]),
    )
    counts, shown = np.zeros(sources.cell), np.zeros(sources.cell)
    together = [
        cheapest_cuts(sheets[0], Offer(sheets[0].windows(some), some, np.arange(len(some) + 1), moved, *of_each))
        for some, moved in ((boxes[:2], shifts[:2]), (boxes[2:], shifts[2:]))
        for of_each in [(np.zeros(len(some)), np.ones(len(some)), np.inf)]
    ]
    order = [(1, 0), (0, 1), (0, 0)]
    one_by_one = [together[group][n] for group, n in order]
    sheets[0].commit_each(together, order, shown)
    before = np.bincount(sheets[1].places[sheets[1].filled], minlength=counts.size)
    for cut in one_by_one:
        sheets[1].commit(cut)
    for name in ("label", "places", "seams"):
        np.testing.assert_array_equal(getattr(sheets[0], name), getattr(sheets[1], name))
    assert (sheets[0].patches, sheets[0].total) == (sheets[1].patches, sheets[1].total)
    assert sheets[0].total == sheets[0].seams.sum() > 0
    after = np.bincount(sheets[1].places[sheets[1].filled], minlength=counts.size)
    np.testing.assert_array_equal(shown.ravel(), after - before)


def test_where_no_patch_is_cheap_enough_nothing_is_laid() -> None:
    rng = np.random.default_rng(4)
    sources = Mosaic([rng.random((2, 20, 20), np.float32)])
    sheet = Sheet(sources, (20, 20), (False, False), SeamCost(sources))
    sheet.lay(Patch(0, (0, 0), Box((0, 0), (20, 20))))
    boxes, before = [Box((3, 3), (8, 8)), Box((12, 12), (6, 6))], sheet.label.copy()
    firsts, shifts, costs = np.array([0, 2, 2]), np.array([[3, 2], [1, 0]]), np.full(2, 5.0)
    cuts = cheapest_cuts(sheet, Offer(sheet.windows(boxes), boxes, firsts, shifts, costs, np.ones(2), 0.0))
    assert [*cuts] == [None, None]
    sheet.commit_each([cuts], [])
    np.testing.assert_array_equal(sheet.label, before)
    assert cheapest_as_offered(sheet, [], lambda group: group) == []


@pytest.mark.parametrize("wraps", [(False, False), (True, True), (False, True, False)])
def test_what_is_known_under_patches_is_counted_pixel_by_pixel(wraps: tuple[bool, ...]) -> None:
    rng, axes, size = np.random.default_rng(1), len(wraps), (7, 6, 5)[: len(wraps)]
    sources = Mosaic([rng.random((1, *size), np.float32)])
    sheet = Sheet(sources, (12, 11, 10)[:axes], wraps, SeamCost(sources))
    sheet.label[rng.random(sheet.shape) < 0.4] = 0
    for _ in range(20):
        start = [int(rng.integers(-2 if w else 0, n - 4)) for n, w in zip(sheet.shape, wraps, strict=True)]
        box = Box(tuple(start), (4, 4, 3)[:axes])
        shifts = np.array(start) - rng.integers(0, 5, (6, axes))
        pixels = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(box.start, box.stop, strict=True))), -1)
        known = sheet.label[tuple((pixels % sheet.shape).reshape(-1, axes).T)] == 0
        under = [((pixels - shift >= 0) & (pixels - shift < size)).all(-1).ravel() for shift in shifts]
        found = sheet.windows([box]).known([box], np.array([0, 6]), shifts, size)
        assert found.tolist() == [int((known & one).sum()) for one in under]
