import itertools

import numpy as np
import pytest
import torch

from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.sheet.pixels import STRETCH
from kwatra.pieces.sheet.regions import Regions


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (False, True), (False,) * 3, (True, False, True)])
@pytest.mark.parametrize("seed", range(3))
def test_the_costliest_region_is_that_of_all_however_often_it_was_asked_for(wraps, seed):
    rng = np.random.default_rng(seed)
    axes = len(wraps)
    mosaic = Mosaic([rng.random((1, *(30, 30, 30)[:axes]), dtype=np.float32)])
    sheet = Sheet(mosaic, (5, 17, 19)[-axes:], wraps, SeamCost(mosaic))
    extent, size = (2, 5, 4)[-axes:], (3, 7, 7)[-axes:]
    regions = Regions(sheet, extent, torch.Generator().manual_seed(seed))
    assert regions.costliest() is None
    for _ in range(12):
        start = [int(rng.integers(n if w else n - e)) for n, e, w in zip(sheet.shape, size, wraps, strict=True)]
        box = Box(tuple(start), size).clipped(sheet.shape, wraps)
        shift = tuple(int(s) for s in start - rng.integers(0, 20, axes))
        sheet.lay(Patch(0, shift, box), must=np.ones(box.extent, bool))
        found, costs = regions.costliest(), {}
        sides = zip(sheet.shape, extent, wraps, strict=True)
        for corner in itertools.product(*(range(n if w else n - e + 1) for n, e, w in sides)):
            costs[corner] = sum(int(seams[sheet.indices(Box(corner, extent))].sum()) for seams in sheet.seams)
            costs[corner] *= float(regions.tried[corner])
        if max(costs.values()) > 0:
            assert found == Box(max(costs, key=costs.__getitem__), extent)  # the first of equals
            before = float(regions.tried[found.start])
            regions.rest(found)
            assert float(regions.tried[found.start]) == before / 2


@pytest.mark.parametrize("wraps", [(False, False), (True, True)])
def test_of_the_costliest_regions_each_lies_far_from_those_before_it(wraps: tuple[bool, bool]) -> None:
    rng = np.random.default_rng(0)
    mosaic = Mosaic([rng.random((1, 12, 300), dtype=np.float32)])
    sheet = Sheet(mosaic, (12, 300), wraps, SeamCost(mosaic))
    sheet.seams[:] = rng.integers(0, 1000, sheet.seams.shape)
    regions, far = Regions(sheet, (2, 3), torch.Generator()), (4, 40)
    sizes = [n if w else n - e + 1 for n, e, w in zip(sheet.shape, (2, 3), wraps, strict=True)]
    starts = [*itertools.product(*map(range, sizes))]
    costs = {at: sum(int(seams[sheet.indices(Box(at, (2, 3)))].sum()) for seams in sheet.seams) for at in starts}

    def away(one: int, other: int, axis: int) -> int:
        apart = abs(one - other)
        return min(apart, sizes[axis] - apart) if wraps[axis] else apart

    def excluded(at: tuple[int, ...], before: tuple[int, ...]) -> bool:
        stretch = [column for column in range(sizes[1]) if column // STRETCH == at[1] // STRETCH]
        beside = any(away(column, before[1], 1) < far[1] for column in stretch)
        return beside and away(at[0], before[0], 0) < far[0]

    expected = list[tuple[int, ...]]()
    while left := [at for at in starts if not any(excluded(at, one) for one in expected)]:
        expected.append(max(left, key=lambda at: costs[at]))  # the first of equals
    found = regions.costliest_apart(50, far)
    assert [box.start for box in found] == expected
    assert len(expected) > 6
    assert all(box.extent == (2, 3) for box in found)
    assert regions.costliest_apart(3, far) == found[:3]
    assert regions.costliest() == found[0]


@pytest.mark.parametrize("wraps", [(False, False), (True, False)])
@pytest.mark.parametrize("stop", [(2, 3), (8, 19), (17, 9), (1, 1), (16, 19)])
def test_a_region_at_the_border_of_what_is_filled_is_about_half_filled_if_any_is(wraps, stop):
    mosaic = Mosaic([np.ones((1, 30, 30), np.float32)])
    sheet = Sheet(mosaic, (17, 19), wraps, SeamCost(mosaic))
    sheet.label[: stop[0], : stop[1]] = 0
    rows = [0, 3, 6, 9, 11] if not wraps[0] else [0, 3, 6, 9, 12, 15, 16]  # every half region, and the last
    at = [Box(corner, (6, 6)) for corner in itertools.product(rows, [0, 3, 6, 9, 12, 13])]
    shares = {box: sheet.filled_at(sheet.indices(box)).mean() for box in at}
    best = min(abs(share - 0.5) for share in shares.values() if 0 < share < 1)
    regions = Regions(sheet, (6, 6), torch.Generator().manual_seed(0))
    found = {regions.frontier() for _ in range(200)}
    off = {box: abs(share - 0.5) for box, share in shares.items() if 0 < share < 1}
    assert found <= {box for box in off if off[box] < best + 0.1 + 1e-9}
    assert found >= {box for box in off if off[box] < best + 0.1 - 1e-9}
