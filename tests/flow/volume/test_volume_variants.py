"""Which copies of a video have the motion that a flow asks for: seen by turning and scaling known motion."""

import pytest
import torch
from torch import Tensor

import flow
from flow.animation.film.drift import drift
from flow.volume.variants import scales, turns
from kwatra import Exemplar

RIGHT, DOWN, LEFT, UP = ((2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0))


def moving(*vectors: tuple[float, float]) -> Tensor:
    return torch.tensor(vectors).repeat(20, 1).T


@pytest.mark.parametrize(
    ("own", "wanted", "expected"),
    [
        ((DOWN,), (RIGHT,), (90.0,)),
        ((DOWN,), (UP,), (180.0,)),
        ((DOWN,), (LEFT,), (270.0,)),
        ((DOWN,), (DOWN,), ()),
        ((DOWN, RIGHT), (LEFT, UP), (180.0,)),
        ((RIGHT,), (RIGHT, DOWN, LEFT, UP), (90.0, 180.0, 270.0)),
        (((0.0, 0.0),), (RIGHT,), ()),
    ],
)
def test_turns_bring_the_directions_that_are_lacking(own, wanted, expected) -> None:
    assert turns(moving(*own), moving(*wanted)) == expected


def test_a_turned_video_moves_as_was_wanted() -> None:
    """The exemplar's own turns and those here mean the same."""
    noise = torch.nn.functional.avg_pool2d(torch.rand(1, 90, 64, generator=torch.Generator().manual_seed(0)), 5, 1, 2)
    clip = torch.stack([noise[:, 20 - 2 * t : 84 - 2 * t] for t in range(4)], 1)  # moves down
    (angle,) = turns(drift(Exemplar.of(clip)).flatten(1), moving(RIGHT))
    turned = torch.rot90(clip, int(angle // 90), (-2, -1))
    seen = flow.seen(turned[:, 0], turned[:, 1])[:, 20:-20, 20:-20].mean((1, 2))
    assert torch.allclose(seen, torch.tensor([2.0, 0.0]), atol=0.4)


def test_scales_bring_the_speed() -> None:
    assert scales(moving(DOWN), moving((3.6, 0.0))) == pytest.approx((1.8,))
    assert scales(moving(DOWN), moving((9.0, 0.0))) == (2.0,)
    assert scales(moving(DOWN), moving((0.5, 0.0))) == (0.5,)
    assert scales(moving(DOWN), moving(RIGHT)) == ()
    assert scales(moving((0.0, 0.0)), moving(RIGHT)) == ()
