import pytest
import torch

from kwatra.base import turned


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def test_quarter_turns_move_pixels_without_changing_them():
    image = torch.rand(2, 9, 9, generator=generator())
    for turns in range(4):
        found = turned(image, (9, 9), 90 * turns, mode="bilinear")
        assert torch.allclose(found, torch.rot90(image, turns, (-2, -1)), atol=1e-5)


@pytest.mark.parametrize("degrees", [0.0, 25.0, -70.0])
def test_a_ramp_turns_and_grows_about_the_center(degrees):
    y, x = torch.meshgrid(torch.arange(41.0) - 20, torch.arange(41.0) - 20, indexing="ij")
    angle = torch.deg2rad(torch.tensor(degrees))
    found = turned(torch.stack([x, y]), (21, 21), degrees, 2.0, "bilinear", "border")
    row, column = torch.meshgrid(torch.arange(21.0) - 10, torch.arange(21.0) - 10, indexing="ij")
    expected = torch.stack(
        [(angle.cos() * column - angle.sin() * row) / 2, (angle.sin() * column + angle.cos() * row) / 2]
    )
    assert torch.allclose(found, expected, atol=1e-4)


def test_frames_of_a_video_turn_alike_and_beyond_the_border_is_nothing():
    video = torch.rand(1, 3, 8, 12, generator=generator())
    found = turned(video, (20, 20), 30.0)
    assert found.shape == (1, 3, 20, 20)
    assert torch.allclose(found[:, 1], turned(video[:, 1], (20, 20), 30.0), atol=1e-6)
    assert not bool(found[..., 0, 0].any())


def test_what_is_smaller_already_stands_for_its_span():
    image = torch.full((1, 40, 40), 0.5)
    small = torch.full((1, 20, 20), 0.5)
    assert torch.equal(turned(image, (20, 20), 0, 0.5) > 0, turned(small, (20, 20), 0, 0.5, span=(40, 40)) > 0)
