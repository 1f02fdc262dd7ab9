"""Feature maps: found where they were drawn, refused where they say nothing."""

import pytest
import torch
from scipy.ndimage import distance_transform_edt

from kwatra import InputError
from synth.metamorphosis.patches.feature_maps import (
    REACH,
    characterizes,
    checked_map,
    distance_channel,
    find_features,
    ridge_strength,
)


def grid(period: int, dark: bool, size: int = 64) -> tuple[torch.Tensor, torch.Tensor]:
    """Joints 2 px wide between noisy cells, and where their middles are."""
    noise = 0.05 * torch.rand(1, size, size, generator=torch.Generator().manual_seed(0))
    line = (torch.arange(size) + 8) % period
    joint = (line < 2)[:, None] | (line < 2)[None]
    image = torch.where(joint, 0.1 if dark else 0.9, 0.5) + noise
    return image, joint


@pytest.mark.parametrize("dark", [True, False])
def test_joints_are_found_dark_or_bright(dark: bool) -> None:
    image, joint = grid(16, dark)
    found = find_features([image])
    away = torch.from_numpy(distance_transform_edt(~found.maps[0].numpy()))
    assert float(away[joint].quantile(0.95)) <= 3
    near = torch.from_numpy(distance_transform_edt(~joint.numpy()))
    assert float(near[found.maps[0]].mean()) < 2
    assert found.sure[0] > 0.5
    assert found.kind in found.remark


@pytest.mark.parametrize("dark", [True, False])
def test_ridges_are_as_strong_as_scikit_image_s(dark: bool) -> None:
    from skimage.filters import sato

    gray = torch.rand(40, 50, generator=torch.Generator().manual_seed(0), dtype=torch.float64).numpy()
    for half_width in (1.0, 1.5, 2.0):
        judge = torch.from_numpy(sato(gray, [half_width], black_ridges=dark))
        own = torch.from_numpy(ridge_strength(gray, half_width, dark))
        torch.testing.assert_close(own, judge, atol=1e-9, rtol=0)


def test_joints_are_whole_where_they_are_many_and_some_are_faint() -> None:
    """Joints that are a third of all pixels, those around dark cells with half of the contrast."""
    _, joint = grid(12, True)
    generator = torch.Generator().manual_seed(1)
    cells = torch.where(torch.rand(6, 6, generator=generator) < 0.5, 0.45, 0.7)
    cell = ((torch.arange(64) + 8) // 12).clamp(max=5)
    image = torch.where(joint, 0.1, cells[cell][:, cell])[None] + 0.02 * torch.rand(1, 64, 64, generator=generator)
    away = torch.from_numpy(distance_transform_edt(~find_features([image]).maps[0].numpy()))
    assert float(away[joint].quantile(0.95)) <= 3


def test_a_map_of_what_is_there_tells_more_than_one_of_something_else() -> None:
    image, joint = grid(16, True)
    other = torch.zeros_like(joint)
    other[torch.randint(0, 64, (300,), generator=torch.Generator().manual_seed(1)), torch.arange(300) % 64] = True
    assert characterizes(joint, image) > characterizes(other, image) + 0.2
    assert characterizes(torch.zeros_like(joint), image) == 0


def test_distances_are_those_to_the_nearest_feature() -> None:
    marks = torch.zeros(20, 40, dtype=torch.bool)
    marks[3, 4] = True
    away = distance_channel(marks)[0]
    assert float(away[3, 4]) == 0
    assert float(away[6, 8]) == pytest.approx(5 / REACH)
    assert float(away[3, 39]) == 1
    assert bool((distance_channel(torch.zeros(5, 5, dtype=torch.bool)) == 1).all())


def test_maps_are_checked() -> None:
    marks = torch.zeros(2, 8, 9)
    marks[1, 2, 3] = 0.8
    assert checked_map(marks, (8, 9), "A").nonzero().tolist() == [[2, 3]]
    for bad in (torch.zeros(8, 9), torch.ones(8, 9), torch.rand(8, 8)):
        with pytest.raises(InputError, match="A"):
            checked_map(bad, (8, 9), "A")
