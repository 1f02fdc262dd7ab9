"""Pictures of flow: the benchmark's colors, and arrows that point where the flow goes."""

import colorsys
import math

import pytest
import torch
from torch import Tensor

import flow
from kwatra import InputError


def toward(degrees: float, length: float = 1.0) -> Tensor:
    """A flow of 3x3 px everywhere in a direction."""
    angle = math.radians(degrees)
    return (length * torch.tensor([math.cos(angle), math.sin(angle)])).view(2, 1, 1).expand(2, 3, 3)


# the wheel has 15 steps from red to yellow, then 6, 4, 11, 13 and 6 to green, cyan, blue, magenta and red
@pytest.mark.parametrize(
    ("step", "color"),
    [(0, (1, 0, 0)), (15, (1, 1, 0)), (21, (0, 1, 0)), (25, (0, 1, 1)), (36, (0, 0, 1)), (49, (1, 0, 1))],
)
def test_directions_have_the_wheels_colors(step: int, color: tuple[int, ...]) -> None:
    drawn = flow.picture(toward(step * 360 / 55))
    assert torch.allclose(drawn[:, 1, 1], torch.tensor(color).float(), atol=2e-3)


def test_hues_go_around_once() -> None:
    hues = [colorsys.rgb_to_hsv(*flow.picture(toward(d))[:, 0, 0].tolist())[0] for d in range(0, 360, 5)]
    assert hues == sorted(hues)


def test_length_is_saturation_up_to_the_fastest() -> None:
    assert torch.equal(flow.picture(torch.zeros(2, 3, 3)), torch.ones(3, 3, 3))
    half = flow.picture(toward(0, 1.0), fastest=2.0)
    assert torch.allclose(half[:, 0, 0], torch.tensor([1.0, 0.5, 0.5]), atol=1e-5)
    beyond = flow.picture(toward(0, 3.0), fastest=2.0)
    assert torch.allclose(beyond[:, 0, 0], torch.tensor([0.75, 0.0, 0.0]), atol=1e-5)


def test_what_is_not_known_is_black_whatever_it_holds() -> None:
    known = torch.ones(3, 3, dtype=torch.bool)
    known[1, 1] = False
    field = toward(0).clone()
    field[:, 1, 1] = math.nan
    drawn = flow.picture(field, known)
    assert drawn[:, 1, 1].tolist() == [0, 0, 0]
    assert torch.allclose(drawn[:, 0, 0], torch.tensor([1.0, 0.0, 0.0]), atol=1e-5)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270, 30])
def test_arrows_point_where_the_flow_goes(degrees: float) -> None:
    field = flow.uniform(angle=degrees)(0.0, (64, 64))
    ink = (flow.picture(field) - flow.picture(field, arrows=64)).sum(0)
    y, x = torch.meshgrid(torch.arange(64) - 31.5, torch.arange(64) - 31.5, indexing="ij")
    middle = torch.stack([(ink * x).sum(), (ink * y).sum()]) / ink.sum()
    along = torch.tensor([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])
    assert float(middle @ along) > 5
    assert abs(float(middle[0] * along[1] - middle[1] * along[0])) < 1


def test_rest_is_a_dot_and_the_wheel_a_disc() -> None:
    drawn = flow.picture(torch.zeros(2, 48, 48), arrows=16)
    assert 0 < int((drawn[0] < 0.5).sum()) < 9 * 30
    key = flow.wheel(65)
    assert key.shape == (3, 65, 65)
    assert torch.allclose(key[:, 32, 32], torch.ones(3))
    assert torch.allclose(key[:, 32, 64], torch.tensor([1.0, 0.0, 0.0]), atol=1e-4)
    assert torch.equal(key[:, 0, 0], torch.ones(3))


def test_impossible_pictures_are_refused() -> None:
    with pytest.raises(InputError, match=r"a flow has shape \(3, 3\)"):
        flow.picture(torch.zeros(3, 3))
    with pytest.raises(InputError, match="arrows every -1 px"):
        flow.picture(toward(0), arrows=-1)
    with pytest.raises(InputError, match="full color at 0 px"):
        flow.picture(toward(0), fastest=0)
