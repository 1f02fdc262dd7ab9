"""Upright copies: rigid ones untouched, turned ones turned back, stiff where there is something to see."""

import math

import numpy as np
import pytest
import torch
from skimage import data
from torch import Tensor

from flow.animation.carrying.copies import angles, changes
from flow.animation.carrying.stiffness import solve
from flow.animation.carrying.upright import Upright
from flow.warps.warp import pixel_coordinates, warp
from kwatra import Exemplar

SHAPE = (20, 24)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)


def gravel(side: int = 64) -> Tensor:
    return torch.from_numpy(data.gravel()[:side, :side].astype(np.float32) / 255)[None]


def turned(degrees: float, size: float = 1.0) -> Tensor:
    center = torch.tensor([12.0, 10.0]).view(2, 1, 1)
    x, y = pixel_coordinates(SHAPE) - center
    cos, sin = size * math.cos(math.radians(degrees)), size * math.sin(math.radians(degrees))
    return torch.stack([cos * x - sin * y, sin * x + cos * y]) + center + 20


def bent(source: Tensor) -> float:
    """How far copies are from rigid: mean squared change of the offset within them."""
    return sum(
        float((change.square().sum(0) * together).mean()) for change, together in changes(source, torch.zeros(SHAPE))
    )


def two_copies() -> Tensor:
    source = turned(0.0)
    source[:, :, 12:] += torch.tensor([7.5, -9.0]).view(2, 1, 1)
    return source


@pytest.mark.parametrize("source", [turned(0.0), two_copies()], ids=["one copy", "two"])
def test_rigid_copies_are_left_bit_for_bit(source: Tensor) -> None:
    assert torch.equal(Upright(Exemplar.of(gravel()), 30.0)(source, WHOLE), source)


@pytest.mark.parametrize("source", [turned(4.0), turned(0.0, 0.93), turned(0.0, 1.06)], ids=["turned", "near", "far"])
def test_what_is_not_rigid_becomes_more_so_with_stiffness(source: Tensor) -> None:
    exemplar = Exemplar.of(gravel())
    after = [bent(Upright(exemplar, stiffness)(source, WHOLE)) for stiffness in (0.0, 10.0, 1000.0)]
    assert after[0] == bent(source)
    assert after[1] < 0.9 * after[0]
    assert after[2] < 0.3 * after[0]


@pytest.mark.parametrize("degrees", [4.0, 75.0, 180.0])
def test_a_turned_copy_that_may_turn_stays_where_it_is(degrees: float) -> None:
    upright = Upright(Exemplar.of(gravel()), 30.0, turning=4.0)
    assert torch.allclose(upright(turned(degrees), WHOLE), turned(degrees), atol=1e-3)


def test_what_may_turn_is_made_rigid_all_the_same() -> None:
    """Turned by 40 degrees and sheared: what is left of the shear is less, and the turn is still there."""
    upright, source = Upright(Exemplar.of(gravel()), 1000.0, turning=4.0), turned(40.0)
    source[0] += 0.08 * (source[1] - source[1].mean())
    after = upright(source, WHOLE)
    strain = [
        sum(float(c.square().mean()) for c, _ in changes(s, angles(s).mean().expand(SHAPE))) for s in (source, after)
    ]
    assert strain[1] < 0.7 * strain[0]
    assert abs(float(angles(after).mean()) - float(angles(source).mean())) < 0.02


def energy(upright: Upright, source: Tensor, u: Tensor) -> float:
    """The energy that is minimized, pair by pair."""
    detail = warp(upright._detail[None], source, "bilinear")[0].double()
    offset, u = (source - pixel_coordinates(SHAPE)).double(), u.double()
    total = float((detail * u.square().sum(0)).sum())
    for y in range(SHAPE[0]):
        for x in range(SHAPE[1]):
            for v, w in ((y + 1, x), (y, x + 1)):
                if v < SHAPE[0] and w < SHAPE[1]:
                    change = offset[:, v, w] - offset[:, y, x]
                    change = change * (change.square().sum() < 1.5**2) / max(1, float(change.norm()) / 0.12)
                    stiff = upright.stiffness * float(min(detail[y, x], detail[v, w])) ** 2
                    total += stiff * float((u[:, v, w] - u[:, y, x] + change).square().sum())
    return total


def test_it_is_the_least_energy() -> None:
    """No small change, at random or of one pixel, makes it smaller."""
    upright, source = Upright(Exemplar.of(gravel()), 5.0), turned(5.0)
    source[:, :, 14:] += 6.25
    u = upright(source, WHOLE) - source
    least = energy(upright, source, u)
    assert least < 0.7 * energy(upright, source, torch.zeros_like(u))
    generator = torch.Generator().manual_seed(0)
    for _ in range(6):
        change = 0.05 * torch.randn(u.shape, generator=generator)
        assert energy(upright, source, u + change) > least
    for y, x in ((0, 0), (10, 13), (10, 14), (19, 23)):
        for step in (-0.05, 0.05):
            change = torch.zeros_like(u)
            change[0, y, x] = step
            assert energy(upright, source, u + change) > least


def test_only_what_is_free_moves() -> None:
    free = WHOLE.clone()
    free[:, :9] = False
    source = turned(5.0)
    after = Upright(Exemplar.of(gravel()), 30.0)(source, free)
    assert torch.equal(after[:, ~free], source[:, ~free])
    assert not torch.equal(after[:, free], source[:, free])
    elsewhere = torch.where(free, source, 900.0)
    assert torch.equal(Upright(Exemplar.of(gravel()), 30.0)(elsewhere, free)[:, free], after[:, free])


def test_elements_are_stiff_and_gaps_give_way() -> None:
    """Two checkered squares on black: they turn back, each about itself; the gap between them takes up the shear."""
    image = torch.zeros(1, 64, 64)
    checks = (torch.arange(64)[:, None] // 2 + torch.arange(64) // 2) % 2
    for left in (21, 35):
        image[0, 24:36, left : left + 9] = checks[24:36, left : left + 9].float()
    source = turned(3.0)
    u = Upright(Exemplar.of(image), 30.0)(source, WHOLE) - source
    (_, _), (across, _) = changes(source + u)
    element, gap = across[:, 8:12, 3:8].square().sum(0).mean(), across[:, 8:12, 11:14].square().sum(0).mean()
    assert float(element) < 0.2 * math.radians(3.0) ** 2
    assert float(gap) > 10 * float(element)


def test_the_system_is_solved() -> None:
    """As by all of its matrix, and far enough for what is asked."""
    rng = np.random.default_rng(0)
    anchor, tall, wide, right = (rng.uniform(0.1, 1, shape).astype(np.float32) for shape in 3 * [(6, 7)] + [(2, 6, 7)])
    tall[[0, -2, -1]], wide[:, [0, -2, -1]] = 0, 0
    right[:, [0, -1]], right[:, :, [0, -1]] = 0, 0
    number, matrix = np.arange(42).reshape(6, 7), np.diag(anchor.ravel()).astype(np.float64)
    for tied, (p, q) in ((tall, (number[:-1], number[1:])), (wide, (number[:, :-1], number[:, 1:]))):
        for one, other, weight in zip(p.ravel(), q.ravel(), tied[: p.shape[0], : p.shape[1]].ravel(), strict=True):
            matrix[[one, other, one, other], [one, other, other, one]] += weight * np.array([1, 1, -1, -1])
    for tolerance in (0.3, 1e-5):
        solution = np.zeros_like(right)
        solve(anchor, tall, wide, right.copy(), tolerance, 99, solution)
        off = right.reshape(2, -1) - solution.reshape(2, -1) @ matrix
        assert tolerance / 100 < np.linalg.norm(off) / np.linalg.norm(right) < 1.1 * tolerance
