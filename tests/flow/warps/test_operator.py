"""A warp as a matrix: one that can be written down, and its transpose, for every kernel, at every border."""

import pytest
import torch
from torch import Tensor

import flow
from flow.warps.warp import KERNELS
from kwatra import InputError

SHAPE = (7, 9)
PLACES = (6, 8)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def coordinates(places: tuple[int, ...] = PLACES, size: float = 14.0) -> Tensor:
    """Places inside, on and beyond every border, between pixels and on them."""
    anywhere = torch.rand(2, *places, generator=generator(), dtype=torch.float64) * size - 3
    anywhere[:, 0] = anywhere[:, 0].round()
    return anywhere


def seen() -> Tensor:
    return torch.rand(PLACES, generator=generator(1)) > 0.3


def dense(mode: str, wrap: bool, known: Tensor | None) -> Tensor:
    """W by reading every unit image with `flow.warp`, (places, pixels)."""
    units = torch.eye(63, dtype=torch.float64).view(63, *SHAPE)
    matrix = flow.warp(units, coordinates(), mode, wrap).flatten(1).T
    return matrix if known is None else matrix * known.flatten()[:, None]


@pytest.mark.parametrize("mode", KERNELS)
@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("known", [None, seen()], ids=["all known", "some known"])
def test_products_are_those_of_the_matrix(mode: str, wrap: bool, known: Tensor | None) -> None:
    matrix, warp = dense(mode, wrap, known), flow.Warp(coordinates(), SHAPE, mode, wrap, known)
    x = torch.rand(3, *SHAPE, generator=generator(2), dtype=torch.float64)
    v = torch.randn(3, *PLACES, generator=generator(3), dtype=torch.float64)
    weights = v.abs()
    assert torch.allclose(warp(x).flatten(1), x.flatten(1) @ matrix.T, atol=1e-12)
    assert torch.allclose(warp.transposed(v).flatten(1), v.flatten(1) @ matrix, atol=1e-12)
    pixels, entries = (part.flatten(1) for part in warp.entries())
    rows = torch.zeros_like(matrix)
    for pixel, entry in zip(pixels, entries, strict=True):
        rows[torch.arange(len(rows)), pixel] += entry
    assert torch.allclose(rows, matrix, atol=1e-12)
    squares = torch.stack([(matrix.T @ torch.diag(w) @ matrix).diagonal() for w in weights.flatten(1)])
    assert torch.allclose(warp.diagonal(weights).flatten(1), squares, atol=1e-12)


@pytest.mark.parametrize("mode", KERNELS)
@pytest.mark.parametrize("wrap", [False, True])
def test_the_transpose_passes_the_dot_product_test(mode: str, wrap: bool) -> None:
    places = (150, 130)  # more than one piece
    known = torch.rand(places, generator=generator(4)) > 0.2
    warp = flow.Warp(coordinates(places, 60.0), (40, 50), mode, wrap, known)
    x = torch.randn(2, 40, 50, generator=generator(2), dtype=torch.float64)
    v = torch.randn(2, *places, generator=generator(3), dtype=torch.float64)
    assert torch.isclose((warp(x) * v).sum(), (x * warp.transposed(v)).sum(), rtol=1e-10)


@pytest.mark.parametrize("mode", KERNELS)
def test_applying_it_is_warping_bit_for_bit(mode: str) -> None:
    places, x = coordinates((150, 130), 60.0).float(), torch.rand(3, 40, 50, generator=generator(2))
    assert torch.equal(flow.Warp(places, (40, 50), mode)(x), flow.warp(x, places, mode))


def test_the_transpose_is_the_same_bits_for_any_number_of_threads() -> None:
    warp = flow.Warp(coordinates((300, 300), 40.0).float(), (40, 30), "bicubic")
    v = torch.randn(3, 300, 300, generator=generator(3))
    results = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        results.append(warp.transposed(v))
    assert torch.equal(results[0], results[1])
    assert torch.equal(results[0], results[2])


def test_what_is_not_known_has_no_influence() -> None:
    nowhere = torch.where(seen(), coordinates(), torch.nan)
    x, v = (torch.rand(1, *size, dtype=torch.float64, generator=generator(2)) for size in (SHAPE, PLACES))
    some, same = (flow.Warp(places, SHAPE, known=seen()) for places in (nowhere, coordinates()))
    assert torch.equal(some(x), same(x))
    assert torch.equal(some.transposed(v), same.transposed(v))
    assert not bool(some(x)[:, ~seen()].any())
    with pytest.raises(InputError, match=r"what is known has shape \(7, 9\) and type torch.bool; give booleans of"):
        flow.Warp(coordinates(), SHAPE, known=torch.ones(SHAPE, dtype=torch.bool))
    with pytest.raises(InputError, match="the interpolation is 'cubic'"):
        flow.Warp(coordinates(), SHAPE, "cubic")
