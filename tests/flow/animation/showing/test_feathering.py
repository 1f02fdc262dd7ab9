"""Seams of flowing videos, over which one copy passes into the other."""

import math

import pytest
import torch
from torch import Tensor

from flow.animation.film.film import Film
from flow.animation.film.reading import Reading
from flow.animation.sequence import Motion
from flow.animation.showing.feathering import feathered, strengths_of
from flow.fields import uniform
from flow.warps import pixel_coordinates
from kwatra import Exemplar

SIDE, REACH = 40, 7


def reading(canvas: Tensor) -> Reading:
    return Reading(Exemplar.of(canvas), "bilinear")


def two_copies(shift: int) -> Tensor:
    """The left half of a frame shows the exemplar's left, the right half places `shift` px farther on."""
    source = pixel_coordinates((SIDE, SIDE)).clone()
    source[0, :, SIDE // 2 :] += shift
    return source


def everywhere() -> Tensor:
    return torch.ones(SIDE, SIDE, dtype=torch.bool)


def feathers(source: Tensor, inside: Tensor, read: Reading, reach: int = REACH, details: bool = True) -> Tensor:
    strong = strengths_of(Exemplar.of(read.continued)) if details else None
    return feathered(read(source), source, inside, read, reach, strong)


def test_a_step_becomes_a_slope_as_long_as_twice_the_reach() -> None:
    two = torch.where(torch.arange(3 * SIDE) < SIDE, 0.2, 0.8).expand(1, SIDE, 3 * SIDE).contiguous()
    seen = feathers(two_copies(SIDE), everywhere(), reading(two))[0]
    row = seen[SIDE // 2]
    assert float(seen.diff(dim=1).max()) < 0.2 * 0.6
    assert float(row.diff().min()) > -0.03  # strengthened details overshoot
    assert torch.allclose(row + row.flip(0), torch.ones(SIDE), atol=1e-4)
    middle = SIDE // 2
    assert torch.equal(row[: middle - REACH], torch.full((middle - REACH,), 0.2))
    assert 0.2 < float(row[middle - REACH + 1]) < float(row[middle - 1]) < 0.5


def test_each_copy_goes_on_as_it_is_turned() -> None:
    """Against the definition, pixel by pixel: copies turned by 40 degrees beside others that are not."""
    slope = torch.stack(torch.meshgrid(torch.arange(90.0), torch.arange(110.0), indexing="ij")) / 110
    read, here, left = reading(slope), pixel_coordinates((SIDE, SIDE)), torch.arange(SIDE) < SIDE // 2
    cos, sin = math.cos(math.radians(40)), math.sin(math.radians(40))
    turned = torch.stack([cos * here[0] + sin * here[1] + 30, -sin * here[0] + cos * here[1] + 40])
    other = here + 20.0
    seen = feathers(torch.where(left, turned, other), everywhere(), read)
    steps = torch.arange(-REACH, REACH + 1.0)
    bell = torch.exp(-2 * (steps / REACH).square())
    for row, column in ((20, 19), (20, 20), (9, 16), (13, 24)):
        across = ((steps + column < SIDE // 2) != bool(left[column])).float()
        share = float((bell * across).sum() / bell.sum())
        own, beyond = (turned, other) if left[column] else (other, turned)
        one, two = (read(copy[:, row, column, None])[:, 0] for copy in (own, beyond))
        assert 0.02 < share < 0.5
        assert torch.allclose(seen[:, row, column], one + share * (two - one), atol=0.02)


def test_copies_that_agree_are_left_as_they_are() -> None:
    wave = 0.5 + 0.4 * torch.sin(2 * math.pi * torch.arange(3.0 * SIDE) / 10).expand(1, SIDE, 3 * SIDE)
    read, source = reading(wave.contiguous()), two_copies(30)
    assert torch.allclose(feathers(source, everywhere(), read, details=False), read(source), atol=1e-6)
    assert torch.allclose(feathers(source, everywhere(), read), read(source), atol=0.005)  # the frame ends within waves


def test_details_of_copies_that_do_not_agree_stay_as_strong() -> None:
    read = reading(torch.rand(3, SIDE, 3 * SIDE, generator=torch.Generator().manual_seed(0)))
    source = two_copies(SIDE)
    before, after = read(source), feathers(source, everywhere(), read)
    near = slice(SIDE // 2 - 2, SIDE // 2 + 2)
    assert not torch.allclose(before[..., near], after[..., near], atol=0.05)
    assert float(after[..., near].std()) == pytest.approx(float(before.std()), rel=0.1)
    assert float(feathers(source, everywhere(), read, details=False)[..., near].std()) < 0.85 * float(before.std())


def test_details_stay_as_strong_where_four_copies_meet() -> None:
    read = reading(torch.rand(30, SIDE, 5 * SIDE, generator=torch.Generator().manual_seed(0)))
    source = two_copies(2 * SIDE)
    source[0, SIDE // 2 :] += SIDE
    middle = (..., *(slice(SIDE // 2 - 2, SIDE // 2 + 2),) * 2)
    plain, seen = (feathers(source, everywhere(), read, details=some)[middle].std() for some in (False, True))
    assert float(plain) < 0.6 * float(read(source).std())
    assert float(seen) > 0.8 * float(read(source).std())


def test_one_copy_and_what_is_outside_keep_every_bit() -> None:
    read = reading(torch.rand(3, SIDE, 3 * SIDE, generator=torch.Generator().manual_seed(1)))
    whole, source = pixel_coordinates((SIDE, SIDE)), two_copies(30)
    assert torch.equal(feathers(whole, everywhere(), read), read(whole))
    assert torch.equal(feathers(source, everywhere(), read, 0), read(source))
    left = everywhere()
    left[:, SIDE // 2 :] = False  # a seam with nothing on its other side is none
    assert torch.equal(feathers(source, left, read), read(source))
    upper = everywhere()
    upper[10:] = False
    assert torch.equal(feathers(source, upper, read)[:, 10:], read(source)[:, 10:])


def test_crumbs_are_grown_over() -> None:
    read = reading(torch.rand(3, SIDE, 3 * SIDE, generator=torch.Generator().manual_seed(2)))
    whole, crumb = pixel_coordinates((SIDE, SIDE)), pixel_coordinates((SIDE, SIDE)).clone()
    crumb[0, 20:24, 10:14] += 40
    assert torch.allclose(feathers(crumb, everywhere(), read), read(whole), atol=1e-5)


def test_fine_detail_beyond_a_seam_is_read_as_sharply_as_elsewhere() -> None:
    stripes = 0.5 + 0.4 * torch.sin(math.pi / 2 * torch.arange(SIDE + 8.0)).view(-1, 1)
    film = Film.of(Exemplar.of(stripes.expand(1, 4, SIDE + 8, 3 * SIDE)))
    motion = Motion(film, uniform(0.0), (SIDE, SIDE), None, None, None, 0)
    steps = motion.showing.picture(two_copies(SIDE) + 0.5, everywhere()).diff(dim=1).abs().mean((0, 1))
    assert float(steps[SIDE // 2]) > 0.9 * float(steps[0])
