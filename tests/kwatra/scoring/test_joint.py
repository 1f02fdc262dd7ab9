"""Joint statistics: of the texture itself and of what has others, by what they see that windows do not."""

import pytest
import torch
from textures import gravel

from kwatra.scoring import Ranking, glance
from kwatra.scoring.joint import JointStatistics, largest_side
from kwatra.scoring.rough import JOINT


def test_a_texture_is_at_0_and_nearer_to_itself_than_to_others() -> None:
    image, other = gravel(128), gravel(128, 200)
    figure = JointStatistics([image], 128)
    assert figure.distance([image]) == 0
    blurred = torch.nn.functional.avg_pool2d(image[None], 5, 1, 2)[0]
    order = torch.randperm(image.numel(), generator=torch.Generator().manual_seed(0))
    scrambled = image.flatten()[order].view_as(image)
    assert figure.distance([other]) < min(figure.distance([blurred]), figure.distance([scrambled]))


def test_all_of_an_image_is_looked_at() -> None:
    image = gravel(150)
    figure = JointStatistics([image], 64)
    for rows, columns in ((slice(64), slice(64)), (slice(70, 80), slice(70, 80)), (slice(140, 150), slice(140, 150))):
        changed = image.clone()
        changed[:, rows, columns] = 0.5
        assert figure.distance([changed]) > 0


def test_what_is_defined_for_one_only_is_left_out() -> None:
    flat = torch.full((1, 64, 64), 0.5)
    assert JointStatistics([flat], 64).distance([flat]) == pytest.approx(0, abs=1e-6)
    assert torch.tensor(JointStatistics([gravel(64)], 64).distance([flat])).isfinite()


@pytest.mark.parametrize(("sides", "largest"), [((300, 256), 256), ((300, 255), 128), ((64,), 64), ((256, 63), None)])
def test_crops_are_as_large_as_all_images_allow(sides: tuple[int, ...], largest: int | None) -> None:
    assert largest_side([torch.zeros(1, side, 400) for side in sides]) == largest


def test_a_thorough_ranking_counts_them_where_they_fit() -> None:
    image, other = gravel(64), gravel(64, 200)
    figure = JointStatistics([image], 64).distance([other])
    expected = (1 - JOINT) * glance(other, image) + JOINT * figure
    assert Ranking(image, thorough=True)(other) == pytest.approx(expected)
    small = image[:, :40, :40]
    assert Ranking(small, thorough=True)(other) == Ranking(small)(other)
