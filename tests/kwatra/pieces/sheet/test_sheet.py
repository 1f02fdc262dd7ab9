"""Laying patches against brute force: no labeling of a small sheet may be cheaper than the one that is chosen."""

import itertools

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams.cost import HIDDEN, Depth, SeamCost, eased, normalized
from kwatra.pieces.seams.mosaic import LEVELS, Mosaic, by_place
from kwatra.pieces.sheet import Patch, Sheet


def labeling_cost(sheet, patch, take):
    """Seam cost of the whole sheet once the pixels in `take` come from `patch`, from colours alone."""
    label = np.where(take, -2, sheet.label)
    patches = {**dict(enumerate(sheet.patches)), -2: patch}
    image = sheet.sources.planes.reshape(len(sheet.sources.planes), -1, *sheet.sources.cell).astype(int)

    def color(number, at):
        home = patches[number]
        n = sheet.sources.shapes[home.number]
        period = [s if w else 10**6 for s, w in zip(sheet.shape, sheet.periodic, strict=True)]
        u = [(a - (b - 1)) % m + (b - 1) for a, b, m in zip(at, home.box.start, period, strict=True)]
        x = [min(max(c - s, -1), m) + 1 for c, s, m in zip(u, home.shift, n, strict=True)]
        return image[(slice(None), home.number, *x)]

    total = 0
    for at in np.ndindex(*sheet.shape):
        for axis in range(len(at)):
            to = tuple(a + (d == axis) for d, a in enumerate(at))
            if to[axis] == sheet.shape[axis]:
                if not sheet.periodic[axis]:
                    continue
                to = tuple(0 if d == axis else a for d, a in enumerate(at))
            if label[at] != label[to] and label[at] != -1 and label[to] != -1:
                total += np.abs(color(label[at], at) - color(label[to], at)).sum()
                total += np.abs(color(label[at], to) - color(label[to], to)).sum()
    return int(total)


@pytest.mark.parametrize(
    ("shape", "source", "periodic"),
    [
        ((5, 6), (4, 4), (False, False)),
        ((6, 6), (4, 4), (True, True)),
        ((3, 4, 4), (3, 3, 3), (False, False, False)),
        ((5, 3, 3), (3, 3, 3), (True, False, False)),
    ],
)
@pytest.mark.parametrize("seed", range(4))
def test_laying_a_patch_over_old_seams_is_optimal(shape, source, periodic, seed, recomputed_seams):
    rng = np.random.default_rng(seed)
    sources = Mosaic([rng.random((2, *source), np.float32)])
    sheet = Sheet(sources, shape, periodic, SeamCost(sources))
    for _ in range(6):
        extent = tuple(min(n, sheet.longest(d)) for d, n in enumerate(source))
        start = tuple(
            int(rng.integers(0, s if w else s - e + 1)) for s, e, w in zip(shape, extent, periodic, strict=True)
        )
        patch = Patch(0, start, Box(start, extent))
        at = sheet.indices(patch.box)
        must = rng.random(extent) < 0.1
        must_not = (rng.random(extent) < 0.1) & ~must & sheet.filled[at]
        free = sheet.filled[at] & ~must & ~must_not
        free.ravel()[np.flatnonzero(free.ravel())[6:]] = False
        held = sheet.filled[at] & ~must & ~free
        best = min(_all_labelings(sheet, patch, at, free, ~free & ~held))
        sheet.lay(patch, must=must, must_not=held)
        assert sheet.total == best
        assert sheet.total == int(sheet.seams.sum())
        np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)


def _all_labelings(sheet, patch, at, free, taken):
    spots = np.argwhere(free)
    for choice in itertools.product([False, True], repeat=len(spots)):
        inside = taken.copy()
        inside[tuple(spots.T)] = choice
        take = np.zeros(sheet.shape, bool)
        take[at] = inside
        yield labeling_cost(sheet, patch, take)


def bag(*values: float, side: int = 4) -> Mosaic:
    """Sources of one color each."""
    return Mosaic([np.full((1, side, side), value, np.float32) for value in values])


def test_of_a_bag_of_four_colors_the_seam_runs_where_the_colors_are_nearest() -> None:
    sources = bag(0.0, 0.4, 0.6, 1.0, side=6)
    sheet = Sheet(sources, (6, 6), (False, False), SeamCost(sources))
    for number, column in ((0, 0), (3, 3)):
        assert sheet.lay(Patch(number, (0, 0), Box((0, column), (6, 3))))
    assert sheet.total == 2 * LEVELS * 6
    # 0 | 1 becomes 0 | 0.4 | 1: between two colors nothing is saved, and nothing is lost
    assert not sheet.lay(Patch(1, (0, 0), Box((0, 1), (6, 4))), cheaper=True)
    # but the color of one side takes all, and then there is no seam
    assert sheet.lay(Patch(0, (0, 0), Box((0, 1), (6, 5))), cheaper=True)
    assert sheet.total == 0
    assert set(sheet.places.ravel() // sources.cell_size) == {0}


def test_a_box_is_full_if_nothing_in_it_is_empty() -> None:
    mosaic = Mosaic([np.random.default_rng(0).random((1, 9, 9))])
    sheet = Sheet(mosaic, (6, 8), (False, True), SeamCost(mosaic))
    sheet.lay(Patch(0, (0, 5), Box((0, 5), (6, 5))))
    assert sheet.full(Box((0, 6), (6, 4)))
    assert sheet.full(Box((2, -3), (3, 5)))
    assert not sheet.full(Box((2, -4), (3, 5)))
    assert not sheet.full(Box((0, 1), (1, 2)))


def test_taking_has_its_price() -> None:
    sources = bag(0.0, 1.0, side=6)
    for price, takes in ((-LEVELS * 9, True), (-LEVELS * 2, False)):
        sheet = Sheet(sources, (6, 6), (False, False), SeamCost(sources))
        sheet.lay(Patch(0, (0, 0), Box((0, 0), (6, 6))))
        taking = np.zeros((4, 4), np.int64)
        taking[1, 1] = price
        patch = Patch(1, (0, 0), Box((1, 1), (4, 4)))
        cut = sheet.cut(patch, taking=taking)
        assert sheet.cut_below(cut.price - 1, patch, taking=taking) is None
        np.testing.assert_array_equal(sheet.cut_below(cut.price, patch, taking=taking).take, cut.take)
        assert bool(cut.take.any()) is takes
        if takes:  # one pixel with four seams of 2 each
            assert int(cut.take.sum()) == 1
            assert (cut.change, cut.price) == (8 * LEVELS, 8 * LEVELS + price)
        assert sheet.lay(cut.patch, taking=taking, cheaper=True) is takes


@pytest.mark.parametrize("periodic", [False, True])
def test_a_new_patch_mends_an_old_seam(periodic: bool) -> None:
    """A stripe laid out of step is covered by one in step: all seams are gone."""
    stripes = np.tile(np.repeat([0.0, 1.0], 2), 6)[None, None].repeat(8, 1).astype(np.float32)  # (1, 8, 24), period 4
    sources = Mosaic([stripes])
    sheet = Sheet(sources, (8, 16), (False, periodic), SeamCost(sources))
    for start in (0, 8):
        sheet.lay(Patch(0, (0, start - 4), Box((0, start), (8, 8))))
    assert sheet.total == 0
    sheet.lay(Patch(0, (0, 1), Box((2, 5), (4, 5))), must=np.ones((4, 5), bool))
    assert sheet.total > 0
    assert sheet.lay(Patch(0, (0, 0), Box((1, 4), (6, 8))), cheaper=True)
    assert sheet.total == 0
    np.testing.assert_array_equal(sources.originals(sheet.places)[0, 3], np.tile([0.0, 0.0, 1.0, 1.0], 4))


def test_what_is_void_or_fixed_stays() -> None:
    sources = bag(0.0, 1.0, side=6)
    sheet = Sheet(sources, (6, 6), (False, False), SeamCost(sources))
    hole = np.zeros((6, 6), bool)
    hole[2, 2] = True
    sheet.lay(Patch(0, (0, 0), Box((0, 0), (6, 6))), must_not=hole)
    assert sheet.label[2, 2] == -1
    sheet.fixed[:, :2] = True
    sheet.lay(Patch(1, (0, 0), Box((0, 0), (6, 6))), must=~hole, must_not=hole)
    assert sheet.label[2, 2] == -1
    assert set(sheet.label[:, :2].ravel()) == {0}


def test_seams_are_hidden_where_one_side_shows_ground():
    image = np.array([[[0, 0.2, 0.4, 0.6, 0.8, 1.0]]], np.float32)
    sources = Mosaic([image])
    depth = np.array([[0, 0, 0, 1, 1, 1]], np.float32)
    cost = SeamCost(sources, depth=Depth(by_place(depth).__getitem__, 100.0))
    places = sources.places(0, [np.arange(1), np.arange(6)])[0]
    plain = SeamCost(sources)

    def both(s, t):
        there = np.array([places[s]]), np.array([places[t]])
        return int(cost.seam(*there, 1, 2)[0]), int(plain.seam(*there, 1, 2)[0])

    for s, t, part, least in ((3, 5, 1, 100), (1, 5, HIDDEN, 0), (5, 1, HIDDEN, 0), (0, 2, HIDDEN, 0), (4, 5, 1, 0)):
        hidden, seen = both(s, t)
        assert hidden == round(part * seen + least)


def test_seams_are_hidden_where_one_side_passes_from_one_part_into_another():
    sources = Mosaic([np.array([[[0, 0.2, 0.4, 0.6, 0.8, 1.0]]], np.float32)])
    depth, part = np.full((1, 6), 0.25, np.float32), np.array([[1, 1, 2, 0, 3, 3]])
    depth_of, part_of = by_place(depth).__getitem__, by_place(part).__getitem__
    cost, plain = SeamCost(sources, depth=Depth(depth_of, 100.0, part=part_of)), SeamCost(sources)
    places = sources.places(0, [np.arange(1), np.arange(6)])[0]
    for s, t in itertools.product(range(6), repeat=2):
        if t != s + 1:
            there = np.array([places[s]]), np.array([places[t]])
            found, seen = int(cost.seam(*there, 1, 2)[0]), int(plain.seam(*there, 1, 2)[0])
            deep = 0.25 if s in (1, 2) or t in (2, 4) else 1.0  # 3 is of no part, and the rim of its neighbor's
            assert found == round((HIDDEN + (1 - HIDDEN) * deep) * seen + 100 * deep)


@pytest.mark.parametrize("seams", ["hidden", "outlined", "eased", "normalized"])
def test_seams_are_remembered_as_they_cost(seams, recomputed_seams):
    rng = np.random.default_rng(0)
    sources = Mosaic([rng.random((2, 9, 9), np.float32)])
    depth, part = by_place(rng.random((9, 9), np.float32)).__getitem__, by_place(rng.integers(0, 3, (9, 9))).__getitem__
    costs_of = {
        "hidden": SeamCost(sources, depth=Depth(depth, 200.0)),
        "outlined": SeamCost(sources, depth=Depth(depth, 200.0, part=part)),
        "eased": eased(sources, [1, 9]),
        "normalized": normalized(sources),
    }
    sheet = Sheet(sources, (16, 16), (False, True), costs_of[seams])
    for _ in range(20):
        start = (int(rng.integers(0, 8)), int(rng.integers(0, 16)))
        sheet.lay(Patch(0, start, Box(start, (9, 9))))
        np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)
        assert sheet.total == int(sheet.seams.sum())


def test_a_patch_has_a_color_beyond_its_border_that_of_the_border() -> None:
    image = np.random.default_rng(0).random((2, 4, 5), np.float32)
    mosaic = Mosaic([image, image[:, :3, :3]])
    planes = mosaic.planes.reshape(2, 2, *mosaic.cell)
    for number, shape in enumerate([(4, 5), (3, 3)]):
        inner = planes[:, number, 1 : shape[0] + 1, 1 : shape[1] + 1]
        rim = planes[:, number, : shape[0] + 2, : shape[1] + 2]
        np.testing.assert_array_equal(rim, np.pad(inner, ((0, 0), (1, 1), (1, 1)), mode="edge"))


def test_around_a_closed_axis_a_patch_leaves_its_neighbors_distinct() -> None:
    mosaic = bag(0.0, 1.0)
    sheet = Sheet(mosaic, (6, 7), (True, False), SeamCost(mosaic))
    assert (sheet.longest(0), sheet.longest(1)) == (4, 7)


def test_what_has_to_be_taken_has_no_price() -> None:
    mosaic = bag(0.0, 1.0)
    sheet = Sheet(mosaic, (4, 4), (False, False), SeamCost(mosaic))
    box = Box((0, 0), (4, 4))
    taking = np.full((4, 4), 10**6)
    empty = sheet.cut(Patch(0, (0, 0), box), taking=taking)
    assert empty.take.all()
    assert empty.price == empty.change == 0
    sheet.commit(empty)
    must = np.zeros((4, 4), bool)
    must[0] = True
    forced = sheet.cut(Patch(1, (0, 0), box), must=must, taking=taking)
    assert (forced.take == must).all()
    assert forced.price == forced.change > 0
