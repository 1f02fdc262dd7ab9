"""Fields by formula: how fast, which way, and with which divergence and curl."""

import math

import pytest
import torch
from torch import Tensor

import flow
from flow.fields.field import Field
from kwatra import InputError

SHAPE = (61, 81)
FIELDS = {
    "uniform": flow.uniform, "rotation": flow.rotation, "sink": flow.sink, "source": flow.source,
    "saddle": flow.saddle, "shear": flow.shear, "vortices": flow.vortices, "stream": flow.stream,
    "waves": flow.waves, "noise": flow.noise, "disc": flow.disc,
}  # fmt: skip
TURNED = ["uniform", "saddle", "shear", "vortices", "stream", "disc"]


def derivatives(v: Tensor) -> tuple[Tensor, Tensor]:
    """Divergence and curl (dv_y/dx - dv_x/dy) inside the frame, by central differences."""
    dx, dy = (v[:, 1:-1, 2:] - v[:, 1:-1, :-2]) / 2, (v[:, 2:, 1:-1] - v[:, :-2, 1:-1]) / 2
    return dx[0] + dy[1], dx[1] - dy[0]


@pytest.mark.parametrize("name", FIELDS)
def test_the_fastest_pixel_has_the_speed_asked_for(name: str) -> None:
    for t in (0.0, 3.7):
        v = FIELDS[name](speed=1.5)(t, SHAPE)
        assert v.shape == (2, *SHAPE)
        assert v.dtype == torch.float32
        assert math.isclose(float(v.norm(dim=0).max()), 1.5, rel_tol=1e-5)


@pytest.mark.parametrize("name", sorted(set(FIELDS) - {"sink", "source", "disc"}))
def test_nothing_piles_up_but_in_sinks_and_sources(name: str) -> None:
    v = FIELDS[name]()(2.0, (240, 320))
    divergence, _ = derivatives(v)
    assert float(divergence.abs().max()) < 3e-3


def test_where_each_goes() -> None:
    right = flow.uniform(2.0)(0.0, SHAPE)
    assert torch.equal(right, torch.tensor([2.0, 0.0]).view(2, 1, 1).expand(2, *SHAPE))
    down = flow.uniform(2.0, 90)(0.0, SHAPE)
    assert torch.equal(down, torch.tensor([0.0, 2.0]).view(2, 1, 1).expand(2, *SHAPE))
    middle, side = (30, 40), (30, 80)
    turning = flow.rotation()(0.0, SHAPE)
    assert float(turning[:, *middle].norm()) == 0
    assert float(turning[1, *side]) > 0  # right of the center down: clockwise on the screen
    divergence, curl = derivatives(turning)
    assert float(curl.std()) < 1e-6 < float(curl.mean())
    out = flow.source()(0.0, SHAPE)
    assert float(out[0, *side]) > 0
    assert torch.equal(flow.sink()(0.0, SHAPE), -out)
    divergence, curl = derivatives(out)
    assert float(curl.abs().max()) < 1e-6 < float(divergence.min())
    drawn = flow.saddle()(0.0, SHAPE)
    assert float(drawn[0, *side]) > 0 > float(drawn[1, 60, 40])
    sheared = flow.shear()(0.0, SHAPE)
    assert float(sheared[0, 60, 3]) == 2
    assert float(sheared[0, 0, 3]) == -2
    assert float(sheared[1].abs().max()) == 0


def test_the_jet_between_two_vortices_and_their_sense() -> None:
    v = flow.vortices()(0.0, SHAPE)
    _, curl = derivatives(v)
    assert float(v[0, 30, 40]) > 0
    assert float(curl[44, 39]) * float(curl[14, 39]) < 0
    assert float((v[0] - v[0].flip(0)).abs().max()) < 1e-5


def test_the_stream_bends_and_rests_beside_it() -> None:
    v = flow.stream()(0.0, SHAPE)
    assert float(v[0].min()) >= 0
    assert float(v[1, :, 20].min()) < -0.3
    assert float(v[1, :, 60].max()) > 0.3
    assert float(v[:, -1].norm(dim=0)[40]) < 0.1


@pytest.mark.parametrize("name", TURNED)
def test_a_field_at_an_angle_is_the_field_turned(name: str) -> None:
    straight = FIELDS[name]()(0.0, (61, 61))
    turned = FIELDS[name](angle=90)(0.0, (61, 61))
    quarter = torch.rot90(straight, -1, (1, 2))  # clockwise on the screen, as x to y
    assert torch.allclose(turned, torch.stack([-quarter[1], quarter[0]]), atol=1e-5)


@pytest.mark.parametrize("field", [flow.waves(period=12), flow.noise(period=12)])
def test_fields_in_time_move_and_come_back(field: Field) -> None:
    assert not field.steady
    start = field(0.0, SHAPE)
    assert torch.allclose(field(12.0, SHAPE), start, atol=1e-4)
    assert float((field(3.0, SHAPE) - start).abs().max()) > 0.5
    assert float((field(0.1, SHAPE) - start).abs().max()) < 0.5


def test_noise_has_a_seed_a_scale_and_may_be_steady() -> None:
    assert flow.noise().steady
    assert torch.equal(flow.noise(seed=3)(0.0, SHAPE), flow.noise(seed=3)(9.0, SHAPE))
    assert not torch.allclose(flow.noise(seed=3)(0.0, SHAPE), flow.noise(seed=4)(0.0, SHAPE), atol=0.1)
    fine, coarse = (derivatives(flow.noise(scale=s)(0.0, SHAPE))[1].abs().mean() for s in (8.0, 60.0))
    assert float(fine) > 3 * float(coarse)


def test_waves_have_their_wavelength() -> None:
    v = flow.waves(wavelength=20.0)(0.0, SHAPE)
    assert torch.allclose(v[:, :, 20:], v[:, :, :-20], atol=1e-4)
    assert float((v[:, :, 10:] + v[:, :, :-10]).abs().max()) < 1e-4


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: flow.sink(math.nan), "a flow's speed is nan; give a finite number of pixels per frame"),
        (lambda: flow.waves(wavelength=0), "the flow's wavelength is 0; give a positive number"),
        (lambda: flow.noise(period=-1), "the flow's period is -1; give a positive number"),
        (lambda: flow.disc(radius=0), "the disc's radius is 0; give a positive number of pixels"),
        (lambda: flow.rotation(100)(0.0, SHAPE), "a flow moves pixels by up to 100 px, beyond the 81x61 frame"),
    ],
)
def test_impossible_fields_are_refused(make: object, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        make()
