"""What is offered of groups, and cut in where it costs least."""

import numpy as np
import pytest
import torch

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic, SeamCost
from kwatra.pieces.sheet import Offer, Patch, Sheet, cheapest_as_offered, cheapest_cuts


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
    offers = []
    for box, window in zip(boxes, sheet.windows(boxes), strict=True):
        shifts = np.array(box.start) - rng.integers(0, 10, (5, 2))
        offers.append(Offer(window, box, shifts, rng.random(5), np.full(5, 1e-4), np.inf))
    told = [offers[:1], [], offers[1:4], offers[4:]]
    asked = list[int]()

    def of_group(group: int) -> list[Offer]:
        asked.append(group)
        return told[group]

    alone = [cheapest_cuts(sheet, [offer])[0] for offer in offers]
    for found in (cheapest_cuts(sheet, offers), cheapest_as_offered(sheet, range(4), of_group)):
        for one, other in zip(alone, found, strict=True):
            assert (one.patch, one.change, one.price) == (other.patch, other.change, other.price)
            np.testing.assert_array_equal(one.take, other.take)
            np.testing.assert_array_equal(one.places[one.take], other.places[one.take])
    assert sorted(asked) == [0, 1, 2, 3]
    assert len({one.patch.shift for one in alone}) > 3


def test_of_nothing_offered_nothing_is_cut():
    sources = Mosaic([np.ones((1, 6, 6), np.float32)])
    sheet = Sheet(sources, (8, 8), (False, False), SeamCost(sources))
    assert cheapest_cuts(sheet, []) == []
    assert cheapest_as_offered(sheet, [], list) == []
    assert cheapest_as_offered(sheet, [[], []], list) == []


@pytest.mark.parametrize("wraps", [(False, False), (True, True), (False, True, False)])
def test_what_is_known_under_patches_is_counted_pixel_by_pixel(wraps: tuple[bool, ...]) -> None:
    rng, axes, size = np.random.default_rng(1), len(wraps), (7, 6, 5)[: len(wraps)]
    sources = Mosaic([rng.random((1, *size), np.float32)])
    sheet = Sheet(sources, (12, 11, 10)[:axes], wraps, SeamCost(sources))
    sheet.label[rng.random(sheet.shape) < 0.4] = 0
    for _ in range(20):
        start = [int(rng.integers(-2 if w else 0, n - 4)) for n, w in zip(sheet.shape, wraps, strict=True)]
        box = Box(tuple(start), (4, 4, 3)[:axes])
        (window,) = sheet.windows([box])
        shifts = np.array(start) - rng.integers(0, 5, (6, axes))
        pixels = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(box.start, box.stop, strict=True))), -1)
        known = sheet.label[tuple((pixels % sheet.shape).reshape(-1, axes).T)] == 0
        under = [((pixels - shift >= 0) & (pixels - shift < size)).all(-1).ravel() for shift in shifts]
        assert window.known(box, shifts, size).tolist() == [int((known & one).sum()) for one in under]
