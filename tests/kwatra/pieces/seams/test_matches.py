"""The matching cost of a window's pairs, compiled, against its definition."""

import numpy as np
import pytest

from kwatra.cut import FREE, KEEP, MOST, TAKE, VOID, best_cut, seams_after
from kwatra.pieces import Depth, SeamCost
from kwatra.pieces.seams.cost import FLAT, NORMALIZED_SCALE, eased, normalized, summed
from kwatra.pieces.seams.mosaic import LEVELS, Mosaic, by_place
from kwatra.pieces.seams.stock import Stock


@pytest.mark.parametrize("shape", [(7, 9), (1, 6), (4, 5, 6)])
def test_compiled_matches_are_those_of_any_stock(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(len(shape))
    mosaic = Mosaic([rng.random((3, *shape)), rng.random((3, *shape))])
    old, new = rng.integers(0, mosaic.planes.shape[1], (2, *(2 * n for n in shape))).astype(mosaic.place_type)
    found, expected = mosaic.matches(old, new), Stock.matches(mosaic, old, new)
    assert len(found) == len(shape)
    for one, other in zip(found, expected, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)


def test_a_match_is_the_sum_of_what_differs_at_both_pixels() -> None:
    image = np.array([[[0.0, 1.0, 4.0, 9.0]]])
    mosaic = Mosaic([image])
    old, new = (mosaic.places_of([np.zeros((1, 2), int), np.array([line])]) for line in ([0, 1], [2, 3]))
    only_second, only_first = mosaic.matches(old, new)[1]
    values = mosaic.planes[0][mosaic.places_of([np.zeros(4, int), np.arange(4)])].astype(int)
    differs = abs(values[0] - values[2]) + abs(values[1] - values[3])
    assert only_second.item() == only_first.item() == differs


def test_a_normalized_match_is_divided_by_the_gradients_of_both_patches_at_both_pixels() -> None:
    mosaic = Mosaic([np.array([[[0.0, 1.0, 4.0, 9.0, 16.0, 11.0]]])])
    values = mosaic.planes[0][mosaic.places_of([np.zeros(6, int), np.arange(6)])].astype(int)
    gradient = [abs(values[i + 1] - values[i - 1]) // 2 for i in range(1, 5)]
    old, new = (mosaic.places_of([np.zeros((1, 2), int), np.array([line])]) for line in ([1, 2], [3, 4]))
    nothing = [np.zeros((0, 2), np.int32), np.zeros((1, 1), np.int32)]
    _, second, first = normalized(mosaic).pairs(old, new, nothing)[1]
    match = abs(values[1] - values[3]) + abs(values[2] - values[4])
    flat = int(4 * FLAT * LEVELS)
    assert second.item() == first.item() == match * NORMALIZED_SCALE // (sum(gradient) + flat)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("seams", ["plain", "hidden", "outlined", "eased", "normalized"])
@pytest.mark.parametrize("priced", [False, True])
def test_a_patch_is_cut_in_by_one_call_as_it_is_step_by_step(axes, seams, priced):
    rng = np.random.default_rng(axes)
    mosaic, shape = Mosaic([rng.random((2, *(9,) * axes), dtype=np.float32)]), (7, 8, 6)[:axes]
    depth = by_place(rng.random(mosaic.shapes[0], dtype=np.float32)).__getitem__
    part = by_place(np.random.default_rng(9).integers(0, 3, mosaic.shapes[0])).__getitem__
    cost = {
        "plain": SeamCost(mosaic),
        "hidden": SeamCost(mosaic, depth=Depth(depth, 3000.0)),
        "outlined": SeamCost(mosaic, depth=Depth(depth, 3000.0, part=part)),
        "eased": eased(mosaic, [1, 9, 3][:axes]),
        "normalized": normalized(mosaic),
    }[seams]
    for _ in range(5):
        old, new = (mosaic.places_of(list(rng.integers(0, 9, (axes, *shape)))) for _ in range(2))
        remembered = [c * rng.integers(0, 2, c.shape, dtype=np.int32) for c in cost.within(old)]
        choice = rng.choice(np.array([FREE, FREE, FREE, KEEP, TAKE, VOID], np.int8), shape)
        taking = rng.integers(-4000, 4000, shape) if priced else None
        take, seams = cost.cut(old, new, remembered, choice, taking, MOST)
        pairs = cost.pairs(old, new, remembered)
        assert (take == best_cut(choice, pairs, taking)).all()
        assert take.any()
        price = summed(seams) - summed(remembered) + (int(taking[take & (choice == FREE)].sum()) if priced else 0)
        found, none = (cost.cut(old, new, remembered, choice, taking, most) for most in (price, price - 1))
        assert none is None
        assert (found[0] == take).all()
        for made, wanted in zip(seams, seams_after(choice, take, pairs), strict=True):
            np.testing.assert_array_equal(made, wanted)
