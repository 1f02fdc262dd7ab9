"""What cannot be seen colors nothing: colors are mixed times their alpha."""

import numpy as np
import torch

from synth.io.alpha import mixed, premultiplied, straight, unmixed
from synth.io.kinds import Kind

RGBA = Kind("uint8", ("R", "G", "B", "A"))


def test_colors_under_no_alpha_count_nothing_and_others_come_back() -> None:
    pixels = torch.tensor([[1.0, 0.2], [0.5, 0.4], [0.0, 0.6], [0.0, 0.5]]).view(4, 1, 2)
    there = premultiplied(pixels, RGBA)
    assert there[:, 0, 0].tolist() == [0, 0, 0, 0]
    torch.testing.assert_close(there[:, 0, 1], torch.tensor([0.1, 0.2, 0.3, 0.5]))
    back = straight(there, RGBA)
    torch.testing.assert_close(back[:, 0, 1], pixels[:, 0, 1])
    assert back[:, 0, 0].tolist() == [0, 0, 0, 0]


def test_what_is_multiplied_already_or_has_no_alpha_is_left_alone() -> None:
    pixels = torch.rand(4, 2, 3, generator=torch.Generator().manual_seed(0))
    assert torch.equal(premultiplied(pixels, Kind("float32", ("R", "G", "B", "A"), premultiplied=True)), pixels)
    assert torch.equal(premultiplied(pixels[:3], Kind("uint8", ("R", "G", "B"))), pixels[:3])


def test_values_of_a_file_are_mixed_and_come_back() -> None:
    array = np.array([[[255, 128, 0, 0], [40, 80, 120, 128], [9, 8, 7, 255]]], np.uint8)
    assert mixed(array, RGBA)[0, 0].tolist() == [0, 0, 0, 0]
    assert np.array_equal(unmixed(mixed(array, RGBA), RGBA)[0, 1:], array[0, 1:])


def test_so_little_alpha_that_no_color_can_be_told_from_it_leaves_none() -> None:
    pixels = torch.tensor([[0.0, 1e-40, 0.5], [0.0, 1e-40, 0.25], [0.0, 0.0, 0.0], [1e-42, 1e-40, 0.5]]).view(4, 1, 3)
    back = straight(pixels, RGBA)
    assert back[:3, 0, :2].abs().max() == 0
    assert torch.equal(back[3], pixels[3])
    assert back[:, 0, 2].tolist() == [1.0, 0.5, 0.0, 0.5]
