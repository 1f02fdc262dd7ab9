"""Seams of videos that are feathered."""

import pytest
import torch

from kwatra import Exemplar, element_size
from kwatra.source import look_up
from synth.texture.feathering import FINE, WIDTH, feathered, near_seams, passage

ALL, NOWHERE = torch.ones(2, dtype=torch.bool), (False,) * 3


def halves(side: int = 48) -> tuple[torch.Tensor, torch.Tensor]:
    """A clip whose frames are all 0 and all 1, and a map of its middle: left of the first, right of the second."""
    clip = torch.stack([torch.zeros(1, 2 * side, 2 * side), torch.ones(1, 2 * side, 2 * side)], 1)
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    where = (
        torch.stack([(x >= side // 2).long(), y + side // 2, x + side // 2])[:, None].expand(-1, 2, -1, -1).contiguous()
    )
    return clip, where


def soft(clip, where, width=WIDTH, wrap=NOWHERE, free=ALL):
    return feathered(look_up(clip, where), where, Exemplar.of(clip), width, wrap, free)


def test_what_meets_passes_over_into_each_other_by_a_gaussian():
    clip, where = halves()
    across = soft(clip, where)[0, 0, 24]
    gaussian = torch.distributions.Normal(0.0, WIDTH)
    expected = gaussian.cdf(torch.arange(48.0) - 23.5)
    assert torch.allclose(across, expected, atol=0.03)
    assert torch.all(across.diff() >= 0)
    assert float(across[:11].max()) == 0.0  # beyond two deviations nothing is touched


def test_a_piece_goes_on_as_in_its_clip_beyond_its_seam():
    z = torch.rand(1, 2, 40, 40, generator=torch.Generator().manual_seed(0))
    y, x = torch.meshgrid(torch.arange(30), torch.arange(30), indexing="ij")
    where = torch.stack([torch.zeros_like(y), y + torch.where(x < 15, 2, 5), x + torch.where(x < 15, 1, 7)])
    where = where[:, None].expand(-1, 2, -1, -1).contiguous()
    width = 2.9
    made = soft(z, where, width)
    steps, weights, values = range(-round(2 * width), round(2 * width) + 1), [], []
    for down in steps:
        for right in steps:
            _, row, column = where[:, 0, 16 + down, 13 + right].tolist()
            weights.append(torch.tensor(-(down**2 + right**2) / width**2 / 2).exp())
            values.append(weights[-1] * z[:, 0, row - down, column - right])
    assert torch.allclose(made[:, 0, 16, 13], sum(values) / sum(weights), atol=1e-5)


def test_within_a_piece_nothing_changes():
    z = torch.rand(3, 2, 40, 40, generator=torch.Generator().manual_seed(0))
    y, x = torch.meshgrid(torch.arange(32), torch.arange(32), indexing="ij")
    where = torch.stack([torch.ones_like(y), y + 3, x + 5])[:, None].expand(-1, 2, -1, -1).contiguous()
    assert torch.equal(soft(z, where), look_up(z, where))


def test_only_large_things_that_do_not_last_are_feathered():
    generator = torch.Generator().manual_seed(0)

    def clip(size: int, frames: int) -> Exemplar:
        """Blobs of so many px in 8 frames, of which so many are unlike."""
        noise = torch.rand(1, frames, 96 // size + 2, 96 // size + 2, generator=generator).movedim(0, 1)
        large = torch.nn.functional.interpolate(noise, scale_factor=size, mode="bicubic")[..., :96, :96]
        return Exemplar.of(large.repeat_interleave(8 // frames, 0).movedim(1, 0))

    wild, fine, lasts = (clip(*sort) for sort in ((24, 8), (3, 8), (24, 1)))
    assert 2.5 < passage(wild) <= min(WIDTH, FINE * element_size(wild)) + 1e-9
    assert passage(fine) == passage(lasts) == 0
    plain, where = halves()
    assert torch.equal(soft(plain, where, 0.0), look_up(plain, where))


def test_frames_that_are_held_are_left_alone():
    clip, where = halves()
    made, copied = soft(clip, where, free=torch.tensor([False, True])), look_up(clip, where)
    assert torch.equal(made[:, 0], copied[:, 0])
    assert not torch.equal(made[:, 1], copied[:, 1])


@pytest.mark.parametrize("wraps", [False, True])
def test_around_an_axis_that_wraps_first_and_last_pixels_meet(wraps):
    clip, where = halves()
    made = soft(clip, where, wrap=(False, False, wraps))
    assert (float(made[0, 0, 24, 0]) > 0.4) is wraps


def test_what_is_mixed_of_a_flame_has_its_colors():
    heat = torch.rand(2, 96, 96, generator=torch.Generator().manual_seed(0))
    heat[:, :48], heat[:, 48:, 48:] = 0, 1
    clip = torch.stack([heat, heat.square(), heat**4])  # black, red, yellow, white
    y, x = torch.meshgrid(torch.arange(40), torch.arange(40), indexing="ij")
    where = torch.stack([torch.zeros_like(y), torch.where(x < 20, 0, 56) + y, 52 + x])
    made = soft(clip, where[:, None].expand(-1, 2, -1, -1).contiguous())[:, 0, 20, 15:25]
    red, green, blue = made
    assert float(red.min()) < 0.5
    assert float(red.max()) > 0.8
    assert torch.allclose(green, red.clamp(0, 1).square(), atol=0.05)
    assert torch.allclose(blue, red.clamp(0, 1) ** 4, atol=0.05)


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (False, True), (True, True)])
@pytest.mark.parametrize("reach", [1, 4])
def test_near_seams_are_pixels_around_which_another_piece_is_seen(wraps, reach):
    generator, shape = torch.Generator().manual_seed(reach), (2, 17, 23)
    pieces = torch.randint(0, 9, (3, 2, 2, 3), generator=generator)
    pieces[:, 0] = pieces[:, 0, :1, :1]  # one frame shows one piece
    at = torch.stack(torch.meshgrid(*(torch.arange(n) for n in shape), indexing="ij"))
    shift = pieces[:, at[0], at[1] // 9, at[2] // 9]
    where = shift + at * torch.tensor([0, 1, 1]).view(3, 1, 1, 1)

    def unlike(t: int, i: int, j: int) -> bool:
        """Whether some pixel around shows what the piece of this one would not."""
        for down in range(-reach, reach + 1):
            for right in range(-reach, reach + 1):
                row, column = i + down, j + right
                if (wraps[0] or 0 <= row < shape[1]) and (wraps[1] or 0 <= column < shape[2]):
                    there = where[:, t, row % shape[1], column % shape[2]] - where[:, t, i, j]
                    if there.tolist() != [0, down, right]:
                        return True
        return False

    expected = torch.tensor([unlike(*pixel.tolist()) for pixel in at.flatten(1).T]).view(shape)
    assert torch.equal(near_seams(where, reach, wraps), expected)
    assert expected[0].any() == any(wraps)
    assert int(expected[1].sum()) > 0
