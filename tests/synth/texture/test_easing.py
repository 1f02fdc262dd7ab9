"""Seams of stills, eased."""

import pytest
import torch

import synth
from kwatra import Exemplar
from kwatra.source import look_up
from synth.texture.easing import APART, FADING, OUTLINE, eased

NOWHERE = (False, False)


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def slope(size=60, rise=0.004):
    """A picture (3, H, W) that becomes brighter to the right and down, a little."""
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    return (0.2 + rise * (x + y)).expand(3, -1, -1).clone()


def two_pieces(size=60, by=20):
    """A map (2, H, W) of the left half of a picture, and on its right of what lies `by` px higher."""
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    return torch.stack([torch.where(x < size // 2, y, (y - by).clamp(min=0)), x])


def test_a_step_goes_over_a_few_pixels_and_elsewhere_pieces_are_copies():
    z, where = slope(), two_pieces()
    x = look_up(z, where)
    soft = eased(x, where, Exemplar.of(z), NOWHERE)
    row = slice(25, 60)  # rows above show the first row again and again
    before, after = (float((one[0, row, 30] - one[0, row, 29]).mean()) for one in (x, soft))
    assert before == pytest.approx(0.004 - 0.08, abs=1e-4)  # it lacks .08
    assert after > 0.6 * before
    assert abs(after) < 0.6 * abs(before)
    assert torch.equal(soft[:, row, :18], x[:, row, :18])
    assert torch.equal(soft[:, row, 42:], x[:, row, 42:])


def test_corrections_solve_their_equations():
    z, where = slope(), two_pieces()
    x = look_up(z, where)
    c = (eased(x, where, Exemplar.of(z), NOWHERE) - x)[0, 40].double()  # far from other rows' steps all is as here
    lack = torch.zeros(59, dtype=torch.float64)
    lack[29] = 0.004 - float(x[0, 40, 30] - x[0, 40, 29])
    step = torch.cat([torch.zeros(1), c.diff() - lack, torch.zeros(1)])
    assert torch.allclose(FADING * c - step.diff(), torch.zeros(()).double(), atol=3e-3)


def test_what_goes_on_is_left_as_it_is():
    z = torch.rand(3, 40, 40, generator=generator())
    y, x = torch.meshgrid(torch.arange(30), torch.arange(30), indexing="ij")
    for where in (torch.stack([y + 4, x + 7]), torch.stack([y + 4 + (x > 15) * APART, x + 7])):  # of one piece
        shown = look_up(z, where)
        assert eased(shown, where, Exemplar.of(z), NOWHERE) is shown


def test_a_period_that_is_exact_is_no_step():
    z = torch.rand(3, 12, 12, generator=generator()).repeat(1, 3, 3)
    y, x = torch.meshgrid(torch.arange(24), torch.arange(24), indexing="ij")
    where = torch.stack([y, torch.where(x < 12, x, x - 12 + 12 * (y > 11))])
    shown = look_up(z, where)
    assert torch.equal(eased(shown, where, Exemplar.of(z), (True, True)), shown)


def test_outlines_stay_and_colors_stay_within_their_range():
    z = (torch.rand(1, 40, 40, generator=generator()) > 0.5).float()
    where = two_pieces(40, 13)
    shown = look_up(z, where)
    assert torch.equal(eased(shown, where, Exemplar.of(z), NOWHERE), shown)  # all steps are of more than OUTLINE
    soft = eased(look_up(slope(), two_pieces()), two_pieces(), Exemplar.of(slope()), NOWHERE)
    assert slope().min() <= soft.min() <= soft.max() <= slope().max()
    assert OUTLINE < 1


@pytest.mark.parametrize("wraps", [False, True])
def test_a_seam_at_the_border_counts_where_the_still_is_periodic(wraps):
    z = slope(40)
    y, x = torch.meshgrid(torch.arange(40), torch.arange(40), indexing="ij")
    where = torch.stack([y, x])
    soft = eased(z, where, Exemplar.of(z), (False, wraps))
    # the last column is brighter than the first by .156, which lies beyond the picture: what changed before goes on
    assert torch.equal(soft, z) != wraps
    if wraps:
        assert float((soft[0, :, 0] - soft[0, :, -1]).abs().max()) < float((z[0, :, 0] - z[0, :, -1]).abs().max())


def test_stills_that_nothing_steers_are_eased_the_same_for_any_number_of_threads():
    z = torch.nn.functional.avg_pool2d(torch.rand(3, 72, 72, generator=generator()), 9, 1)
    made = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        made.append(synth.synthesize(z, (100, 90), seed=1))
    assert torch.equal(made[0].image, made[1].image)
    result, exemplar = made[0].result, made[0].form.normalized(z)
    again = eased(result.image, result.where, Exemplar.of(exemplar), NOWHERE)
    assert float((again - result.image).abs().max()) < float(
        (look_up(exemplar, result.where) - result.image).abs().max()
    )
