"""Walls of bricks of many lengths: blocks are laid in step with their courses, which stay straight."""

import pytest
import torch
from made import MADE

from kwatra import Exemplar, Settings
from kwatra.elements import find_repeats
from kwatra.elements.rows import Rows
from kwatra.loop.beginning import begin
from kwatra.pieces import find_cells

HIGH = 17
"""Pixels from a course of bricks that have the area of a square of 24 pixels to the next."""


@pytest.mark.parametrize("seed", [0, 1])
def test_bricks_stay_in_their_courses_and_straight(seed: int) -> None:
    wall = Exemplar.of(MADE["courses"](128, 24, seed).image)
    assert isinstance(find_repeats(wall), Rows)
    assert find_cells(wall) is not None  # each could be moved and stretched alone
    beginning = begin(wall, (160, 192), Settings(), seed=seed)
    assert beginning.where is not None
    off = (beginning.where[0] - torch.arange(160)[:, None] + HIGH // 2) % HIGH
    first = off.flatten().mode().values
    assert bool(((off - first + HIGH // 2) % HIGH - HIGH // 2).abs().le(1).all())
