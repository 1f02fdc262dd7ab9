"""Flow around obstacles: beside the formula, and nothing flows in."""

import numpy as np
import pytest
import torch
from PIL import Image, ImageDraw
from torch import Tensor

import flow
from flow.fields.edge import Edge
from flow.fields.field import Field
from flow.warps.warp import pixel_coordinates
from kwatra import InputError

SHAPE = (96, 120)


def star() -> Tensor:
    """A jagged obstacle with a bay, a thin bar that touches the border, and a single pixel."""
    image = Image.new("L", (120, 96), 255)
    draw = ImageDraw.Draw(image)
    draw.polygon([(30, 25), (80, 35), (60, 50), (85, 75), (35, 70), (50, 48)], fill=0)
    draw.rectangle([100, 60, 103, 96], fill=0)
    draw.point([15, 80], fill=0)
    return torch.from_numpy(np.array(image) > 0)


def landing_in(field: Field, mask: Tensor, t: float = 0.0) -> int:
    """How many pixels of the texture are carried into the obstacle."""
    landed = flow.warp(mask[None].float(), pixel_coordinates(SHAPE) + field(t, SHAPE), "nearest")[0] > 0
    return int((mask & ~landed).sum())


@pytest.mark.parametrize("name", ["uniform:20", "rotation", "sink", "waves", "noise"])
def test_nothing_flows_into_an_obstacle(name: str) -> None:
    mask, free = star(), flow.named(name)
    bent = flow.around(free, mask)
    assert landing_in(free, mask, 3.0) > 20
    assert landing_in(bent, mask, 3.0) == 0
    v = bent(3.0, SHAPE)
    assert float(v[:, ~mask].abs().max()) == 0
    assert 1.0 < float(v.norm(dim=0).max()) < 2.0001


def test_at_a_wall_the_flow_is_tangent() -> None:
    mask = torch.ones(SHAPE, dtype=torch.bool)
    mask[40:60, 50:80] = False
    v = flow.around(flow.uniform(angle=60), mask)(0.0, SHAPE)
    assert float(v[1, 39, 55:75].abs().max()) < 0.15
    assert float(v[0, 39, 55:75].abs().min()) > 0.15
    assert float(v[0, 45:55, 49].abs().max()) < 0.15
    # and so it is behind it, where nothing pushes back what would flow out of the wall
    assert float(v[1, 60, 52:72].abs().max()) < 0.15
    assert float(v[0, 45:55, 80].abs().max()) < 0.15


def test_around_a_disc_it_is_the_formula() -> None:
    shape, radius = (160, 160), 12.0
    mask = flow.disc_mask(shape, radius=radius)
    solved = flow.around(flow.uniform(angle=25), mask)(0.0, shape)
    formula = flow.disc(angle=25, radius=radius)(0.0, shape)
    distance = (pixel_coordinates(shape) - 79.5).norm(dim=0)
    ring = (distance > radius + 3) & (distance < 3 * radius)
    scale = float((solved * formula)[:, ring].sum() / (formula * formula)[:, ring].sum())
    error = (solved - scale * formula).norm(dim=0)[ring] / (scale * formula).norm(dim=0)[ring].mean()
    assert float(error.mean()) < 0.04
    unbent = (flow.uniform(angle=25)(0.0, shape) / 2 - formula / 2).norm(dim=0)[ring].mean()
    assert float(unbent) > 0.15  # which the formula itself would miss by far if it did nothing


def test_the_disc_is_tangent_and_symmetric() -> None:
    mask = flow.disc_mask(SHAPE, (50.0, 45.0), 20.0)
    assert bool(mask[45, 71])
    assert not bool(mask[45, 69])
    assert not bool(mask[26, 50])
    v = flow.disc(center=(50.0, 45.0), radius=20.0)(0.0, SHAPE)
    assert landing_in(flow.disc(center=(50.0, 45.0), radius=20.0), mask) == 0
    assert landing_in(flow.uniform(), mask) > 20
    assert float(v[0, 45, 25]) < 0.75 * float(v[0, 20, 50])
    assert float((v[0, 5:86] - v[0, 5:86].flip(0)).abs().max()) < 1e-4


def test_sinks_and_far_regions_stay_as_they_are() -> None:
    mask = torch.ones((160, 160), dtype=torch.bool)
    mask[78:82, 78:82] = False
    free = flow.uniform()(0.0, (160, 160))
    bent = flow.around(flow.uniform(), mask)(0.0, (160, 160))
    assert float((bent - free)[:, :40].norm(dim=0).max()) < 0.03
    assert torch.equal(flow.around(flow.sink(), torch.ones_like(mask))(0.0, (160, 160)), flow.sink()(0.0, (160, 160)))


def test_what_an_obstacle_encloses_rests() -> None:
    mask = torch.ones(SHAPE, dtype=torch.bool)
    mask[30:60, 40:80] = False
    mask[40:50, 50:70] = True
    v = flow.around(flow.uniform(), mask)(0.0, SHAPE)
    assert float(v[:, 42:48, 52:68].abs().max()) < 1e-3
    assert float(v[0, 10].mean()) > 0.5


def test_a_frame_of_another_size_or_without_texture_is_refused() -> None:
    with pytest.raises(InputError, match=r"a mask has shape \(96, 120\) and type torch.bool; give booleans of shape"):
        flow.around(flow.uniform(), star())(0.0, (50, 50))
    with pytest.raises(InputError, match="a mask covers every pixel"):
        flow.around(flow.uniform(), torch.zeros(SHAPE, dtype=torch.bool))


def test_what_would_land_in_a_wall_slides_along_it() -> None:
    mask = torch.ones(SHAPE, dtype=torch.bool)
    mask[:, 70:] = False
    kept = Edge(mask).keep_out(torch.tensor([1.2, 0.9]).view(2, 1, 1).expand(2, *SHAPE))
    assert torch.allclose(kept[1, 5:-5, 60:70], torch.tensor(0.9), atol=0.05)
    assert float(kept[0, 5:-5, 69].abs().max()) < 0.15
    assert torch.allclose(kept[0, 5:-5, :67], torch.tensor(1.2))
    assert float(kept[:, :, 70:].abs().max()) == 0


def test_what_no_push_frees_rests() -> None:
    generator = torch.Generator().manual_seed(0)
    mask = torch.rand(SHAPE, generator=generator) < 0.6  # gaps of a pixel or two
    kept = Edge(mask).keep_out(6 * torch.randn(2, *SHAPE, generator=generator))
    landed = flow.warp(mask[None].float(), pixel_coordinates(SHAPE) + kept, "nearest")[0] > 0
    assert bool(landed[mask].all())
    assert float((kept.norm(dim=0)[mask] > 1).float().mean()) > 0.1
