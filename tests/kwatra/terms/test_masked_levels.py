"""What a mask takes away of terms and images on a coarser level, of an output whose border cuts blocks."""

import torch

from kwatra import HardPixels, Quadratic
from kwatra.terms import Controls

SHAPE, FACTORS = (5, 7), (2, 2)


def mask():
    """Block (0, 0) is half hidden, (1, 1) all but one pixel, (2, 3), which the border cuts, and (0, 3) all."""
    inside = torch.ones(SHAPE, dtype=torch.bool)
    inside[:2, 0] = False
    inside[2:4, 2:4] = torch.tensor([[False, False], [False, True]])
    inside[4, 6] = False
    inside[:2, 6] = False
    return inside


class Twisted:
    """x^T F x with an F of rank 1 that mixes all pixels."""

    name = "twisted"

    def at(self, factor, shape):
        return self

    def energy(self, x):
        return self.quadratic(x).value(x)

    def quadratic(self, x):
        along = torch.arange(1.0, x.numel() + 1).view_as(x)
        return Quadratic(along.square(), torch.zeros_like(x), lambda v: along * (along * v).sum())


def test_a_block_counts_if_any_of_its_pixels_does():
    coarse = Controls((), mask(), FACTORS, SHAPE, 1, "cpu").mask
    hidden = torch.zeros(1, 3, 4, dtype=torch.bool)
    hidden[0, 2, 3] = hidden[0, 0, 3] = True
    assert torch.equal(coarse, ~hidden)


def test_a_coarser_image_averages_what_is_not_masked():
    image = torch.rand(2, *SHAPE, generator=torch.Generator().manual_seed(0))
    made = Controls((), mask(), FACTORS, SHAPE, 2, "cpu").shrunk(torch.where(mask(), image, torch.nan))
    assert torch.allclose(made[:, 0, 0], image[:, :2, 1].mean(1))
    assert torch.allclose(made[:, 1, 1], image[:, 3, 3])
    assert torch.allclose(made[:, 2, 0], image[:, 4, :2].mean(1))
    assert not made[:, 2, 3].any()


def test_an_operator_sees_nothing_behind_the_mask_and_wants_nothing_there():
    inside = mask()[None]
    (cut,) = Controls((Twisted(),), mask(), (1, 1), SHAPE, 1, "cpu").quadratics(torch.zeros(1, *SHAPE))
    x = torch.rand(1, *SHAPE, generator=torch.Generator().manual_seed(1))
    whole = Twisted().quadratic(x)
    assert torch.allclose(cut.times(x), inside * whole.times(inside * x))
    assert torch.equal(cut.diagonal, inside * whole.diagonal)


def test_scaled_terms_are_masked_as_they_are():
    where = torch.ones(1, *SHAPE, dtype=torch.bool)
    hard = HardPixels(torch.full((1, *SHAPE), 0.5), where)
    blank = torch.zeros(1, 3, 4)
    alone, scaled = ((f * hard).within(mask()).at(FACTORS, (3, 4)).quadratic(blank) for f in (1.0, 3.0))
    (plain,) = (hard.within(mask()).at(FACTORS, (3, 4)).quadratic(blank),)
    assert torch.equal(alone.fixed, plain.fixed)
    assert torch.equal(alone.diagonal, plain.diagonal)
    assert torch.equal(scaled.fixed, plain.fixed)
    assert torch.equal(scaled.diagonal, 3 * plain.diagonal)
    assert bool(plain.fixed[0, 0, 0])  # half of the block is masked, all the rest given


def test_hard_pixels_times_0_fix_nothing():
    hard = HardPixels(torch.full((1, *SHAPE), 0.5), torch.ones(1, *SHAPE, dtype=torch.bool))
    for factor, fixes in ((0.0, False), (0.5, True)):
        assert (Controls((factor * hard,), None, (1, 1), SHAPE, 1, "cpu").given is not None) == fixes
