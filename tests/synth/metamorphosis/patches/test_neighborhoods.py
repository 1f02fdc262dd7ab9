"""Neighborhoods in between: known motions, alone at the ends, three textures as two."""

import pytest
import torch

from synth.metamorphosis.patches.neighborhoods import Neighborhoods, between_nodes, lattice, similarity

WIDTH = 9


def wave(shift: float = 0.0, size: int = 40) -> torch.Tensor:
    """Something smooth (2, H, W) that moves to the right by `shift`."""
    y, x = torch.meshgrid(torch.arange(size).float(), torch.arange(size).float(), indexing="ij")
    x = x - shift
    return torch.stack([0.5 + 0.4 * torch.sin(x / 4) * torch.cos(y / 5), 0.5 + 0.4 * torch.cos(x / 6 + y / 7)])


def moved(shift: float, count: int = 2) -> Neighborhoods:
    """Neighborhoods of a wave and one that lies `shift` to the right, with splines that know it."""
    centers = torch.cartesian_prod(torch.arange(12, 28, 3), torch.arange(12, 28, 3))[:, None].expand(-1, count, -1)
    there = torch.zeros(len(centers), count, len(lattice(WIDTH)), 2)
    there[:, 1, :, 0] = shift
    return Neighborhoods(WIDTH, (1.0,) * count, torch.zeros(len(centers), dtype=torch.long), centers, there, -there)


def cut(image: torch.Tensor, centers: torch.Tensor) -> torch.Tensor:
    half = WIDTH // 2
    return torch.stack(
        [image[:, y - half : y + half + 1, x - half : x + half + 1].permute(1, 2, 0) for y, x in centers.tolist()]
    )


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
def test_a_shifted_texture_passes_through_the_half_shifted_one(share: float) -> None:
    made = moved(3.0)
    windows = made.windows([wave(), wave(3.0)], (1 - share, share))
    # seen from the anchor's place the texture in between has moved by its share
    half = cut(wave(3.0 * share), made.centers[:, 0])
    assert float((windows - half).abs().mean()) < 0.005


def test_without_warping_waves_are_blended_in_place() -> None:
    made = Neighborhoods(WIDTH, (1.0, 1.0), moved(0).anchor, moved(0).centers)
    windows = made.windows([wave(), wave(3.0)], (0.25, 0.75))
    expected = 0.25 * cut(wave(), made.centers[:, 0]) + 0.75 * cut(wave(3.0), made.centers[:, 1])
    assert float((windows - expected).abs().max()) < 1e-5


def test_alone_a_texture_is_itself() -> None:
    made = moved(3.0)
    assert torch.equal(made.windows([wave(), wave(3.0)], (1.0, 0.0)), cut(wave(), made.centers[:, 0]))
    assert torch.equal(made.windows([wave(), wave(3.0)], (0.0, 1.0)), cut(wave(3.0), made.centers[:, 1]))


def test_of_three_textures_one_that_weighs_nothing_does_not_count() -> None:
    two, three = moved(2.0), moved(2.0, 3)
    noise = torch.rand(2, 40, 40, generator=torch.Generator().manual_seed(0))
    one = two.windows([wave(), wave(2.0)], (0.4, 0.6))
    other = three.windows([wave(), wave(2.0), noise], (0.4, 0.6, 0.0))
    assert float((one - other).abs().max()) < 1e-5


def test_scale_goes_geometrically() -> None:
    made = Neighborhoods(WIDTH, (0.5, 2.0), moved(0).anchor, moved(0).centers)
    assert made.scale((1.0, 0.0)) == pytest.approx(0.5)
    assert made.scale((0.5, 0.5)) == pytest.approx(1.0)
    assert made.scale((0.0, 1.0)) == pytest.approx(2.0)
    # alone each is shown at its own size
    assert torch.equal(made.windows([wave(), wave(3.0)], (0.0, 1.0)), cut(wave(3.0), made.centers[:, 1]))


def test_displacements_between_nodes_are_exact_where_they_are_linear() -> None:
    places = torch.tensor([[0.3, -2.0], [3.9, 4.0], [-4.0, 0.0]])
    nodes = lattice(WIDTH)
    weight = between_nodes(places, WIDTH)
    assert torch.allclose(weight.sum(0), torch.ones(3), atol=1e-5)
    assert torch.allclose(nodes.T @ weight, places.T, atol=1e-4)


def test_what_fits_is_more_similar() -> None:
    right, wrong = moved(3.0), moved(-3.0)
    textures = [torch.cat([w, w[:1]]) for w in (wave(), wave(3.0))]
    assert bool((similarity(right, textures, 1.0) > similarity(wrong, textures, 1.0)).all())
    assert float(similarity(right, textures, 1.0).mean()) > 0.97
