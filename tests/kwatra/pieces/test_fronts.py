"""Boxes that are worked on at once, against what is asked of every pair."""

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.fronts import alike, fronts, last_apart


def apart(one, other, reach, shape, periodic):
    """Whether two boxes lie `reach` or more apart along some axis, pixel by pixel."""
    for axis, (size, wraps) in enumerate(zip(shape, periodic, strict=True)):
        lines = (np.arange(box.start[axis], box.stop[axis]) for box in (one, other))
        steps = np.abs(np.subtract.outer(*lines))
        steps = np.minimum(steps % size, -steps % size) if wraps else steps
        if steps.min() - 1 >= reach:
            return True
    return False


@pytest.mark.parametrize("periodic", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("reach", [0, 3, 9])
def test_each_box_comes_as_soon_as_all_earlier_ones_near_it_are_there(periodic, reach):
    rng, shape = np.random.default_rng(reach), (40, 60)
    low = [-4 if wraps else 0 for wraps in periodic]
    boxes = [Box(tuple(rng.integers(low, [35, 54]).tolist()), (5, 6)) for _ in range(25)]
    found = fronts(boxes, reach, shape, periodic)
    group = {number: k for k, numbers in enumerate(found) for number in numbers}
    assert sorted(group) == list(range(25))
    assert max(map(len, found)) > 1
    for number, box in enumerate(boxes):
        near = [k for k in range(number) if not apart(box, boxes[k], reach, shape, periodic)]
        assert group[number] == max((group[k] + 1 for k in near), default=0)
        assert last_apart(boxes[: number + 1], reach, shape, periodic) == (not near)


def test_rows_of_blocks_that_touch_follow_each_other_three_apart():
    boxes = [Box((24 * row, 24 * column), (32, 32)) for row in range(4) for column in range(7)]
    found = fronts(boxes, 32, (200, 200), (False, False))
    assert found[6] == [6, 10, 14]  # (0, 6), (1, 3), (2, 0)


def test_boxes_of_one_extent_come_together_a_few_at_a_time():
    extents = [(4, 4), (4, 5), (4, 4), (4, 4), (4, 5)]
    assert alike([Box((0, number), extent) for number, extent in enumerate(extents)], 2) == [[0, 2], [3], [1, 4]]
    assert alike([], 2) == []
