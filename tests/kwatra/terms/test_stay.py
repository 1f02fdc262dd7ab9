"""What belongs somewhere stays there."""

import pytest
import torch

from kwatra import Exemplar, InputError, Level, Settings, Stay, optimize


def bands(frames: int = 6) -> torch.Tensor:
    """A scene: noise above that is dark, below that is bright, so that every window says where it comes from."""
    noise = 0.2 * torch.rand(1, frames, 24, 24, generator=torch.Generator().manual_seed(3))
    noise[:, :, 12:] += 0.8
    return noise


def test_what_a_window_costs_grows_with_the_square_of_its_distance_in_frames():
    exemplar = Exemplar.of(torch.rand(1, 2, 9, 17, generator=torch.Generator().manual_seed(0)))
    charge = Stay(2.0).place_charge(exemplar, (2, 9, 17), (1, 1, 1))
    assert charge is not None
    here = torch.tensor([[0, 0, 0], [1, 8, 16]])
    there = torch.tensor([[[0, 0, 0], [1, 2, 0], [0, 0, 8]], [[0, 8, 16], [0, 8, 12], [0, 0, 0]]])
    variance = float(exemplar.variances.mean())
    far = torch.tensor([[0, 1 / 4, 1 / 2], [0, 1 / 4, 2**0.5]])  # shares of the frame
    torch.testing.assert_close(charge(here, there), 2 * variance * (far / 0.25) ** 2)


def test_places_are_shares_of_the_frame_whatever_the_resolution_and_the_output():
    exemplar = Exemplar.of(torch.rand(1, 1, 32, 32, generator=torch.Generator().manual_seed(0)))
    fine = Stay(1.0).place_charge(exemplar, (1, 64, 64), (1, 8, 8))
    coarse = Stay(1.0).place_charge(exemplar.coarser((1, 2, 2)), (1, 32, 32), (1, 4, 4))
    assert fine is not None
    assert coarse is not None
    corner = torch.tensor([[0, 16, 40]])
    ratio = float(exemplar.coarser((1, 2, 2)).variances.mean() / exemplar.variances.mean())
    a = fine(corner, torch.tensor([[[0, 20, 4]]]))
    b = coarse(corner // 2, torch.tensor([[[0, 10, 2]]]))
    assert float(b / a) == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("factor", [1, 2])
def test_a_scene_made_larger_keeps_what_is_above_above(factor):
    exemplar = Exemplar.of(bands())
    shape, settings = (6, 24 * factor, 24 * factor), Settings(levels=(Level(1, 4, 2, 2),))
    above = slice(0, 10 * factor)
    free = optimize(exemplar, shape, settings=settings, seed=1)
    kept = optimize(exemplar, shape, settings=settings, seed=1, terms=Stay(10.0))
    assert float((kept.image[:, :, above] < 0.5).float().mean()) > 0.99
    assert float((kept.image[:, :, above] < 0.5).float().mean()) >= float(
        (free.image[:, :, above] < 0.5).float().mean()
    )
    far = (kept.source[2] / 23 - torch.arange(24 * factor).view(-1, 1) / (24 * factor - 1)).abs()
    assert float(far.mean()) < 0.1  # rows come from their own place
    assert (kept.energies[-1]["stay"] > 0) == (factor > 1)  # at its own size a scene is itself


def test_a_scaled_term_scales_what_it_charges_for_places():
    exemplar = Exemplar.of(bands())
    corners, there = torch.tensor([[0, 3, 5]]), torch.tensor([[[0, 9, 5], [1, 3, 20]]])
    charge, threefold = (term.place_charge(exemplar, (6, 30, 30), (2, 4, 4)) for term in (Stay(0.5), 3.0 * Stay(0.5)))
    assert float(charge(corners, there).min()) > 0
    assert torch.equal(threefold(corners, there), 3 * charge(corners, there))


def test_terms_of_one_name_charge_together():
    exemplar, settings = Exemplar.of(bands()), Settings(levels=(Level(1, 4, 2, 1),))
    whole, both = (
        optimize(exemplar, (6, 30, 30), settings=settings, terms=terms)
        for terms in (Stay(0.5), 0.25 * Stay(0.5) + 0.75 * Stay(0.5))
    )
    assert both.energies[-1]["stay"] == pytest.approx(whole.energies[-1]["stay"], rel=1e-3)


def test_a_weight_of_0_changes_nothing():
    exemplar, settings = Exemplar.of(bands()), Settings(levels=(Level(1, 4, 2, 2),))
    plain = optimize(exemplar, (6, 30, 30), settings=settings)
    assert torch.equal(plain.image, optimize(exemplar, (6, 30, 30), settings=settings, terms=Stay(0.0)).image)


@pytest.mark.parametrize("weight", [-1.0, float("nan"), float("inf")])
def test_a_weight_that_is_none_is_refused(weight):
    with pytest.raises(InputError, match="weight of staying"):
        Stay(weight)
