"""What fields share: sums, scalings, time, size; and their names."""

import math

import pytest
import torch

import flow
from flow.fields.field import Field
from kwatra import InputError

SHAPE = (24, 32)


def noise(frames: int = 3) -> torch.Tensor:
    return torch.randn(frames, 2, *SHAPE, generator=torch.Generator().manual_seed(0))


def test_fields_add_and_scale() -> None:
    a, b = flow.rotation(), flow.uniform(1.0, 45)
    both = 2.0 * a + b * 0.5
    assert both.steady
    assert torch.allclose(both(0.0, SHAPE), 2 * a(0.0, SHAPE) + 0.5 * b(0.0, SHAPE))
    assert not (both + flow.waves()).steady


def test_what_moves_nowhere_stays_so_at_any_speed() -> None:
    assert torch.equal(flow.rotation(8.0)(0.0, (1, 1)), torch.zeros(2, 1, 1))


def test_a_field_of_ones_own_is_any_function() -> None:
    grown = Field(lambda t, shape: torch.full((2, *shape), t / 10))
    assert float(grown(5.0, SHAPE)[0, 0, 0]) == 0.5


def test_a_result_may_be_changed_without_changing_the_field() -> None:
    for field in (flow.sampled(noise(1)), flow.around(flow.uniform(), flow.disc_mask(SHAPE))):
        before = field(0.0, SHAPE)
        field(0.0, SHAPE).zero_()
        assert torch.equal(field(0.0, SHAPE), before)


def test_samples_are_interpolated_in_time_and_hold_beyond_their_ends() -> None:
    flows = noise()
    field = flow.sampled(flows)
    assert not field.steady
    for i in range(3):
        assert torch.equal(field(i, SHAPE), flows[i])
    assert torch.allclose(field(1.25, SHAPE), 0.75 * flows[1] + 0.25 * flows[2], atol=1e-6)
    assert torch.equal(field(99.0, SHAPE), flows[2])
    assert torch.equal(field(-1.0, SHAPE), flows[0])
    assert flow.sampled(flows[0]).steady


def test_another_size_is_refused_or_resampled_on_request() -> None:
    with pytest.raises(InputError, match=r"a flow is 32x24 but the frame 64x48; give one of that size, or resample it"):
        flow.sampled(noise())(0.0, (48, 64))
    steady = flow.sampled(torch.tensor([1.0, 2.0]).view(2, 1, 1).expand(2, *SHAPE), resample=True)
    larger = steady(0.0, (48, 96))
    assert torch.allclose(larger, torch.tensor([3.0, 4.0]).view(2, 1, 1).expand(2, 48, 96))


def test_a_resampled_rotation_still_turns_every_point_alike() -> None:
    turning = flow.rotation(1.0)
    small, large = turning(0.0, (60, 60)), 2 * turning(0.0, (120, 120))
    resampled = flow.resampled(small, (120, 120))
    ratio = float(large.norm(dim=0).max() / resampled.norm(dim=0).max())
    assert torch.allclose(resampled[:, 4:-4, 4:-4] * ratio, large[:, 4:-4, 4:-4], atol=0.02)


def test_the_speed_of_samples_is_that_of_their_fastest_pixel() -> None:
    for shape in (SHAPE, (48, 40)):
        field = flow.sampled(noise(), resample=True, speed=1.5)
        fastest = [float(field(t, shape).norm(dim=0).max()) for t in range(3)]
        assert math.isclose(max(fastest), 1.5, rel_tol=1e-5)
        assert min(fastest) < 1.5
    assert torch.allclose(
        flow.sampled(1000 * noise(), speed=1.5)(1.0, SHAPE), flow.sampled(noise(), speed=1.5)(1.0, SHAPE)
    )


@pytest.mark.parametrize(
    ("flows", "sentence"),
    [
        (torch.zeros(3, 4, 5), r"flows have shape \(1, 3, 4, 5\); give \(2, H, W\), or \(T, 2, H, W\) in time"),
        (torch.zeros(0, 2, 4, 5), r"flows have shape \(0, 2, 4, 5\)"),
        (torch.full((2, 4, 5), math.nan), "20 vectors that are NaN or infinite; fill them"),
        (torch.full((2, 4, 5), 7.0), "beyond the 5x4 frame"),
    ],
)
def test_samples_that_are_no_flow_are_refused(flows: torch.Tensor, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        flow.sampled(flows)


def test_rest_has_no_speed() -> None:
    with pytest.raises(InputError, match="zero everywhere and cannot be brought to a speed of 2"):
        flow.sampled(torch.zeros(2, 4, 5), speed=2.0)


# ---- names


@pytest.mark.parametrize("name", flow.NAMES)
def test_every_name_has_its_field(name: str) -> None:
    field = flow.named(name, speed=1.0)
    maker = getattr(flow, name)
    assert torch.equal(field(1.0, SHAPE), maker(1.0)(1.0, SHAPE))
    assert math.isclose(float(flow.named(name)(0.0, SHAPE).norm(dim=0).max()), 2.0, rel_tol=1e-5)


def test_a_number_after_the_name() -> None:
    assert torch.equal(flow.named("uniform:30")(0.0, SHAPE), flow.uniform(angle=30)(0.0, SHAPE))
    assert torch.equal(flow.named("noise:7")(0.0, SHAPE), flow.noise(seed=7)(0.0, SHAPE))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("snik", r"'snik' names no flow; give one of uniform, rotation, .*"),
        ("sink:3", "'sink:3' has a number, but this flow takes none; leave it out"),
        ("uniform:down", "'uniform:down' has no number for its angle; write it as in uniform:90 or noise:7"),
        ("uniform:nan", "'uniform:nan' has no number for its angle"),
        ("noise:1.5", "'noise:1.5' has no number for its seed"),
    ],
)
def test_names_that_are_none_are_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        flow.named(text)
