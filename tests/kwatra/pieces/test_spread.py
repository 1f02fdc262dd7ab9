"""Where blocks start in the output."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.spread import Spread


def test_a_block_may_hang_over_by_half_towards_those_that_follow_alone():
    spread = Spread.over((40, 60), (20, 20), (5, 5), (1, 1), (False, False))
    first, last = Box((0, 0), (20, 20)), Box((20, 40), (20, 20))
    needed = spread.needed([first, last], (4, 6))
    assert needed[1].all()
    assert needed[0, :18, :17].all()
    assert needed[0].sum() == 18 * 17
    assert spread.needed([first, last], (0, 0)).all()
    back = replace(spread, backwards=(0,)).needed([last, first], (4, 6))
    np.testing.assert_array_equal(back[:, ::-1].sum((1, 2)), [18 * 20, 20 * 17])
    assert back[0, 2:].all()
    assert back[1, :, :17].all()


def test_blocks_are_spread_evenly_and_hang_over_by_what_they_overlap_more_than_needed():
    found = Spread.over((100, 90), (40, 30), (10, 6), (4, 4), (False, True))
    assert found.corners == [(row, column) for row in (0, 32, 60) for column in (0, 24, 44, 68)]
    assert (found.first, found.last) == ([{0}, {0}], [{60}, {68}])
    assert found.overhang((0, 0)) == (8, 4)
    assert found.overhang((5, 9)) == (0, 0)
    assert Spread.over((40, 30), (40, 30), (0, 0), (4, 4), (False, False)).overhang((0, 0)) == (0, 0)


def test_a_block_lies_around_a_region_as_far_as_grain_and_border_admit():
    found = Spread.over((100, 90), (40, 30), (10, 6), (4, 4), (False, True))
    assert found.around(Box((50, 50), (12, 6)), (100, 90), (False, True)) == (36, 40)  # 36 and 38, of 36 and 40
    assert found.around(Box((2, 2), (4, 4)), (100, 90), (False, True)) == (0, -12)
    assert found.around(Box((95, 80), (5, 5)), (100, 90), (False, False)) == (60, 60)


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("wraps", [False, True])
def test_lines_of_blocks_are_out_of_step_and_cover_all(along, wraps):
    shape, block, overlap = ((120, 96), (40, 12), (10, 3)) if along == 0 else ((96, 120), (12, 40), (3, 10))
    found = Spread.over(shape, block, overlap, (2, 2), (wraps, wraps), along)
    covered = np.zeros(shape, int)
    for row, column in found.corners:
        assert row % 2 == column % 2 == 0
        assert wraps or (row + block[0] <= shape[0] and column + block[1] <= shape[1])
        covered[np.ix_((row + np.arange(block[0])) % shape[0], (column + np.arange(block[1])) % shape[1])] += 1
    assert covered.min() > 0
    assert found.corners == sorted(found.corners)
    lines = dict[int, list[int]]()
    for corner in found.corners:
        lines.setdefault(corner[1 - along], []).append(corner[along])
    firsts = [[start for start in line if wraps or 0 < start < shape[along] - block[along]] for line in lines.values()]
    for one, other in pairwise(firsts):
        assert not set(one) & set(other)
    assert all(found.last[along] >= {line[-1]} for line in lines.values())
    steps = [np.diff(line).max() for line in lines.values()]
    assert found.strides[along] == max(steps) <= block[along] - overlap[along] + 2


def test_of_videos_blocks_beside_each_other_are_out_of_step_at_all_times():
    found = Spread.over((10, 60, 40), (4, 20, 20), (1, 5, 5), (1, 1, 1), (False,) * 3, 1)
    assert found.corners == sorted(found.corners)
    still = Spread.over((60, 40), (20, 20), (5, 5), (1, 1), (False, False), 0)
    times = sorted({corner[0] for corner in found.corners})
    assert times == [0, 3, 6]
    for time in times:
        assert [corner[1:] for corner in found.corners if corner[0] == time] == still.corners
    assert found.last == [{6}, *still.last]
    assert found.strides == (3, *still.strides)
