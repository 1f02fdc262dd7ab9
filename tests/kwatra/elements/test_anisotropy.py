"""Anisotropy: slopes whose ratio is known."""

import math

import pytest
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.elements import anisotropy, easier, runs_along

Y, X = torch.meshgrid(torch.arange(30.0), torch.arange(40.0), indexing="ij")


@pytest.mark.parametrize(
    ("image", "ratio"),
    [
        (3 * X + 2 * Y, 1.5),
        (X - 4 * Y, 0.25),
        (X, math.inf),
        (Y, 0.0),
        (torch.full((30, 40), 0.3), 1.0),
    ],
)
def test_slopes_are_compared(image: Tensor, ratio: float):
    assert anisotropy(Exemplar.of(image[None] / 200)) == pytest.approx(ratio, rel=1e-3)


def test_all_channels_and_pictures_count_but_not_what_a_mask_hides():
    image = torch.stack([3 * X, 4 * X, 2 * Y]) / 200
    assert anisotropy(Exemplar.of([image, image.flip(1)])) == pytest.approx(2.5, rel=1e-3)
    mask = torch.ones(30, 40, dtype=torch.bool)
    mask[10:20, 10:20] = False
    hidden = torch.where(mask, image, torch.rand(3, 30, 40, generator=torch.Generator().manual_seed(0)))
    assert anisotropy(Exemplar.of([hidden], masks=[mask])) == pytest.approx(2.5, rel=1e-3)


def test_seams_beside_lines_are_seen_as_much_less_as_there_changes_more() -> None:
    rows = torch.rand(3, 12, 96, generator=torch.Generator().manual_seed(0)).repeat_interleave(8, 1)
    still, turned = Exemplar.of(rows), Exemplar.of(rows.mT)
    much = anisotropy(still)
    assert 2 < much < 4
    assert easier(anisotropy(still), 0) == (1.0, much)
    assert easier(anisotropy(turned), 1) == pytest.approx((much, 1.0), rel=1e-5)
    assert easier(anisotropy(still), None) == (1.0, 1.0)
    flat = rows[:, :1].expand(-1, 96, -1)
    assert easier(anisotropy(Exemplar.of(flat)), 0) == (1.0, 64.0)  # nothing changes along it
    assert easier(anisotropy(Exemplar.of(flat.mT)), 1) == (64.0, 1.0)


def test_a_still_runs_along_the_axis_it_changes_less_along():
    assert [runs_along(ratio, 4.0) for ratio in (1.0, 3.9, 0.26)] == [None] * 3
    assert [runs_along(ratio, 4.0) for ratio in (4.0, 9.0, math.inf)] == [0] * 3
    assert [runs_along(ratio, 4.0) for ratio in (0.25, 0.1, 0.0)] == [1] * 3
