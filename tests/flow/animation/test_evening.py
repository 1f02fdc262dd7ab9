"""Light that goes on evenly over the seams of a flowing frame."""

import pytest
import torch

import flow
from flow.animation.evening import evened
from flow.animation.reading import Reading
from flow.warps import pixel_coordinates
from kwatra import Exemplar, InputError

SIDE = 48


def ramp() -> Reading:
    """An exemplar that grows brighter to the right, by .005 a pixel, and does nothing else."""
    bright = (0.2 + 0.005 * torch.arange(2.0 * SIDE)).expand(3, SIDE, 2 * SIDE)
    return Reading(Exemplar.of(bright.clone()), "bilinear")


def two_copies(shift: int = 30) -> torch.Tensor:
    """The left half of a frame shows the exemplar's left, the right half places `shift` px farther on."""
    source = pixel_coordinates((SIDE, SIDE)).clone()
    source[0, :, SIDE // 2 :] += shift
    return source


def everywhere() -> torch.Tensor:
    return torch.ones(SIDE, SIDE, dtype=torch.bool)


def test_a_step_of_light_becomes_a_slope_that_fades():
    read, source = ramp(), two_copies()
    image = read(source)
    even = evened(image, source, everywhere(), read, 8.0)
    step = image[0, 0].diff()[SIDE // 2 - 1]
    assert float(step) == pytest.approx(0.155, abs=1e-4)  # 31 px on the ramp
    assert float((even[0].diff(dim=1)[:, SIDE // 2 - 1]).abs().max()) < 0.1 * float(step)
    light = (even - image)[0]
    assert torch.allclose(light, light[:1].expand_as(light), atol=1e-5)
    assert float(light[0, SIDE // 2 - 1]) == pytest.approx(0.075, abs=0.01)
    assert float(light[0, 0].abs()) < 0.25 * float(light[0, SIDE // 2 - 1])


def test_it_is_the_least_of_its_sum():
    """Against the normal equations, written out along a row: all rows are alike."""
    read, source = ramp(), two_copies()
    image = read(source)
    found = (evened(image, source, everywhere(), read, 6.0) - image)[0, 5].double()
    wanted = torch.zeros(SIDE - 1, dtype=torch.double)
    wanted[SIDE // 2 - 1] = -0.15  # what the step is more than the ramp's own
    step = torch.eye(SIDE, dtype=torch.double).diff(dim=0)
    least = torch.linalg.solve(step.T @ step + torch.eye(SIDE, dtype=torch.double) / 36, step.T @ wanted)
    assert torch.allclose(found, least, atol=1e-4)


def test_rows_and_columns_are_treated_alike():
    read, source = ramp(), two_copies()
    turned = Reading(Exemplar.of(read.continued.transpose(1, 2).contiguous()), "bilinear")
    mirrored = source.flip(0).transpose(1, 2).contiguous()
    one = evened(read(source), source, everywhere(), read, 8.0)
    other = evened(turned(mirrored), mirrored, everywhere(), turned, 8.0)
    assert torch.allclose(one, other.transpose(1, 2), atol=1e-5)


def test_what_has_no_seams_or_is_not_to_be_evened_keeps_every_bit():
    read, source = ramp(), two_copies()
    whole = pixel_coordinates((SIDE, SIDE))
    assert torch.equal(evened(read(whole), whole, everywhere(), read, 8.0), read(whole))
    assert torch.equal(evened(read(source), source, everywhere(), read, 0.0), read(source))
    left = everywhere()
    left[:, SIDE // 2 :] = False  # a seam with nothing on its other side is none
    assert torch.equal(evened(read(source), source, left, read, 8.0), read(source))


def test_what_is_outside_is_left_alone_and_colors_stay_in_range():
    read, source = ramp(), two_copies(47)
    inside = everywhere()
    inside[:10] = False
    even = evened(read(source), source, inside, read, 40.0)
    assert torch.equal(even[:, :10], read(source)[:, :10])
    assert float(even.max()) <= float(read.continued.max()) + 1e-6
    assert not torch.equal(even, read(source))


def test_a_negative_reach_is_refused():
    with pytest.raises(InputError, match="negative"):
        flow.Renewing(light=-1.0)
