"""Boxes that are worked on at once, against what is asked of every pair."""

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.fronts import MANY, alike, fronts, last_apart, outwards


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
    assert fronts([], 32, (200, 200), (False, False)) == [[]]


def test_boxes_of_one_extent_come_together_a_few_at_a_time():
    extents = [(4, 4), (4, 5), (4, 4), (4, 4), (4, 5)]
    assert alike([Box((0, number), extent) for number, extent in enumerate(extents)], 2) == [[0, 2], [3], [1, 4]]
    assert alike([], 2) == []


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("reach", [20, 45])
def test_both_sides_of_the_middle_lie_apart_and_the_one_before_it_is_backwards(axis, reach):
    rows, columns = (26, 3) if axis == 0 else (3, 26)
    boxes = [Box((15 * row, 15 * column), (20, 20)) for row in range(rows) for column in range(columns)]
    middle, before, behind = outwards(boxes, axis, reach)
    assert sorted(map(repr, [*middle, *before, *behind])) == sorted(map(repr, boxes))
    assert all(apart(one, other, reach, (400, 400), (False, False)) for one in before for other in behind)
    lines = [sorted({box.start[axis] for box in part}) for part in (before, middle, behind)]
    assert lines[0][-1] < lines[1][0] <= lines[1][-1] < lines[2][0]
    assert abs(len(lines[0]) - len(lines[2])) <= 1
    assert len(lines[1]) == -(-(reach + 5) // 15)  # no more than are needed for that
    assert [box.start for box in before] == sorted((box.start for box in before), key=lambda at: -at[axis])
    assert behind == [box for box in boxes if box.start[axis] >= lines[2][0]]


def test_few_boxes_have_no_middle_nor_do_those_that_cannot_lie_apart():
    boxes = [Box((15 * row, 0), (20, 20)) for row in range(40)]
    assert MANY == 8
    assert outwards(boxes[:10], 0, 20) is None  # 155 pixels
    assert outwards(boxes[:11], 0, 20) is not None
    assert outwards(boxes[:11], 0, 145) is None
    assert outwards(boxes, 1, 20) is None
