"""What the border of a picture leaves of an element is told apart from the elements beside it, however little."""

import numpy as np
import pytest
from made import MADE
from scipy import ndimage

from kwatra import Exemplar
from kwatra.elements import find_ground
from kwatra.elements.merging import merged
from kwatra.elements.parting import at_edge, parted


def tips_told(kind: str, size: int, seed: int) -> list[bool]:
    """Of elements of which the border leaves less than a tenth whether they are by themselves, most of each."""
    made = MADE[kind](128, size, seed)
    numbers, (parts, _) = made.numbers.numpy(), ndimage.label(find_ground(Exemplar.of(made.image)).depth > 0)
    area, told = np.bincount(numbers.ravel()), []
    for number in at_edge(numbers, np.ones_like(numbers, bool)):
        if 6 <= area[number] < 0.1 * np.median(area[1:]):
            within, every = (
                np.bincount(p, minlength=parts.max() + 1) for p in (parts[numbers == number], parts.ravel())
            )
            within[0] = 0
            told.append(bool(within.any()) and 2 * within.max() >= every[within.argmax()])
    return told


@pytest.mark.parametrize(("kind", "share"), [("rubble", 0.7), ("mosaic", 0.7), ("buttons", 1.0)])
def test_tips_of_elements_are_no_part_of_others_nor_ground(kind: str, share: float) -> None:
    told = [one for size in (20, 32) for seed in range(4) for one in tips_told(kind, size, seed)]
    assert len(told) >= 5
    assert np.mean(told) >= share


def test_a_part_at_the_edge_is_cut_by_the_border_or_by_what_is_not_inside() -> None:
    number, inside = np.zeros((9, 9), int), np.ones((9, 9), bool)
    number[0, 2], number[4, 4], number[6, 6], number[8, 8] = 1, 2, 3, 4
    assert at_edge(number, inside).tolist() == [1, 4]
    inside[6, 7] = False
    assert at_edge(number, inside).tolist() == [1, 3, 4]


def test_parts_at_the_edge_may_be_smaller_but_no_crumbs() -> None:
    ground, inside = np.ones((12, 12), bool), np.ones((12, 12), bool)
    ground[0:2, 0:3] = ground[5:7, 5:8] = ground[11, 10:] = ground[9:12, 2:6] = False
    number = parted(ground, inside, 10)
    assert (number[0:2, 0:3] > 0).all()
    assert not number[5:7, 5:8].any()
    assert not number[11, 10:].any()
    assert (number[9:12, 2:6] > 0).all()


def test_specks_that_are_spared_are_merged_across_weak_borders_alone() -> None:
    parts, strength = np.repeat([1, 2, 3], (2, 6, 2))[:, None].repeat(8, 1), np.zeros((10, 8))
    strength[2] = strength[8] = 1.0
    assert len(np.unique(merged(parts, strength, 0.5, 20))) == 1
    assert len(np.unique(merged(parts, strength, 0.5, 20, [1, 3]))) == 3
    assert len(np.unique(merged(parts, strength, 0.5, 20, [1]))) == 2
    assert len(np.unique(merged(parts, strength, 1.5, 20, [1, 3]))) == 1
