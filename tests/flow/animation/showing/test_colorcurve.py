"""Colors about their curve, and what mixing them there does to a texture's colors."""

import pytest
import torch
from torch import Tensor

from flow.animation.showing.colorcurve import ColorCurve
from kwatra import Exemplar


def flames() -> Tensor:
    """A clip (3, 6, 20, 24) of black, red, orange, yellow and white, on one curve."""
    heat = 3 * torch.rand(6, 20, 24, generator=torch.Generator().manual_seed(0))
    return torch.stack([heat, heat - 1, heat - 2]).clamp(0, 1)


@pytest.mark.parametrize("channels", [1, 2, 3])
def test_colors_come_back(channels: int) -> None:
    clip = flames()[-channels:] + 0.1 * torch.rand(channels, 6, 20, 24, generator=torch.Generator().manual_seed(1))
    curve = ColorCurve(Exemplar.of(clip))
    assert torch.allclose(curve.colors(curve.of(clip)), clip, atol=1e-6)


def test_what_lies_on_the_curve_differs_from_it_by_little() -> None:
    found = ColorCurve(Exemplar.of(flames())).of(flames())
    assert float(found[0].std()) > 0.5
    assert float(found[1:].abs().mean()) < 0.01


def test_black_and_white_of_a_flame_make_orange() -> None:
    curve = ColorCurve(Exemplar.of(flames()))
    black, white = curve.of(torch.tensor([0.0, 1.0]).expand(3, 2)).unbind(1)
    red, green, blue = curve.colors((black + white)[:, None] / 2).flatten().tolist()
    assert red > 0.9
    assert 0.2 < green < 0.8
    assert blue < 0.1


def test_colors_on_a_line_are_mixed_as_they_are() -> None:
    gray = torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(2))
    line = torch.cat([gray, 0.5 * gray + 0.2, 1 - gray])
    curve = ColorCurve(Exemplar.of(line))
    one, other = line[:, :8], line[:, 8:16]
    mixed = curve.colors((curve.of(one) + curve.of(other)) / 2)
    assert torch.allclose(mixed, (one + other) / 2, atol=1e-5)


def test_masked_colors_do_not_count() -> None:
    image, mask = flames()[:, 0].clone(), torch.ones(20, 24, dtype=torch.bool)
    image[:, 10:], mask[10:] = 100.0, False
    alone = ColorCurve(Exemplar.of(image[:, :10])).of(image)
    assert torch.equal(ColorCurve(Exemplar.of(image, masks=[mask])).of(image), alone)
