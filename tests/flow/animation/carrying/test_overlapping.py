"""Overlapping: where copies meet, seams find the gap that is near, and one of two elements stays whole."""

import math

import pytest
import torch
from made import MADE
from torch import Tensor

import flow
from flow.animation import sequence
from flow.animation.carrying.copies import parted, rigid, turned
from flow.animation.carrying.overlapping import overlapped
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar
from kwatra.pieces import blocks, hidden_seams

SHAPE = (24, 30)
SEAM = 15
WHOLE = torch.ones(SHAPE, dtype=torch.bool)
SIDE = 100


def everywhere(source: Tensor) -> Tensor:
    return torch.ones_like(source[0], dtype=torch.bool)


def copy_of(x: float, y: float, degrees: float = 0.0) -> Tensor:
    """A copy of the exemplar, turned in it, that shows (x, y) where the seam's uppermost pixel is."""
    below, beside = (step.view(2, 1, 1) for step in rigid(torch.tensor(math.radians(degrees))))
    across, down = pixel_coordinates(SHAPE)
    return torch.tensor([x, y]).view(2, 1, 1) + below * down + beside * (across - SEAM)


def meeting(degrees: float = 0.0) -> Tensor:
    """Two copies that meet in a straight seam."""
    source = copy_of(30.0, 30.0, degrees)
    source[:, :, SEAM:] = copy_of(70.0, 60.0)[:, :, SEAM:]
    return source


def around_gap(degrees: float = 0.0) -> Tensor:
    """How deep elements lie in an exemplar: 1, but for a gap where the first of two copies that meet would go on."""
    column, row = pixel_coordinates((SIDE, SIDE)) - 31
    angle = math.radians(degrees)
    return ((column * math.cos(angle) + row * math.sin(angle)).abs() > 1.2).float()


def moved(source: Tensor, depth: Tensor, times: int = 9, free: Tensor = WHOLE, inside: Tensor = WHOLE) -> Tensor:
    for _ in range(times):
        source = overlapped(source, free, inside, depth, everywhere)
    return source


def price(source: Tensor, depth: Tensor) -> float:
    """What the module says is made less."""
    column, row = source.round().long()
    deep = depth[row, column]
    seams, _ = parted(source, WHOLE, turned(source), ((0, 1), (1, 0)))
    pairs = torch.minimum(deep[:, :-1], deep[:, 1:]), torch.minimum(deep[:-1], deep[1:])
    return float(
        sum(((pair + 0.1) * seam).sum() for pair, seam in zip(pairs, (seams[0, :, :-1], seams[1, :-1]), strict=True))
    )


@pytest.mark.parametrize("degrees", [0.0, 90.0])
def test_a_seam_beside_a_gap_moves_into_it_and_stays(degrees: float) -> None:
    source, depth = meeting(degrees), around_gap(degrees)
    wanted = torch.where(pixel_coordinates(SHAPE)[0] <= SEAM, copy_of(30.0, 30.0, degrees), source)
    assert torch.allclose(moved(source, depth, 1), wanted, atol=1e-4)
    assert torch.allclose(moved(source, depth), wanted, atol=1e-4)


def test_a_copy_goes_over_another_only_where_it_may_and_there_is_texture() -> None:
    source, depth = meeting(), around_gap()
    half = pixel_coordinates(SHAPE)[1] < 11
    free = moved(source, depth, free=half)
    assert torch.equal(free[:, 11:], source[:, 11:])
    assert not torch.equal(free[:, :10], source[:, :10])
    beyond = torch.where(half, source, 5.0)
    assert torch.equal(moved(source, depth, inside=half)[:, half], moved(beyond, depth, inside=half)[:, half])
    beside = pixel_coordinates(SHAPE)[0] >= SEAM  # nothing is there that could go over
    assert torch.equal(moved(source, depth, inside=beside), source)


def test_nothing_goes_over_to_what_the_exemplar_lacks() -> None:
    source = meeting()
    assert torch.equal(overlapped(source, WHOLE, WHOLE, around_gap(), lambda at: at[0] != 30), source)


@pytest.mark.parametrize("degrees", [0.0, 90.0])
def test_one_copy_stays_bit_for_bit(degrees: float) -> None:
    source = copy_of(30.0, 30.0, degrees)
    assert torch.equal(moved(source, around_gap(degrees)), source)


def test_seams_come_to_cost_less_in_every_frame() -> None:
    generator = torch.Generator().manual_seed(0)
    patches = 7.0 * torch.randint(0, 10, (2, *(side // 3 for side in SHAPE)), generator=generator)
    source = pixel_coordinates(SHAPE) + patches.repeat_interleave(3, 1).repeat_interleave(3, 2)
    depth = torch.rand(SIDE, SIDE, generator=generator)
    prices = [price(source, depth)]
    for _ in range(3):
        source = moved(source, depth, 1)
        prices.append(price(source, depth))
    assert prices[1] < 0.8 * prices[0]
    assert prices == sorted(prices, reverse=True)


def test_fewer_seams_lead_through_elements_that_flow(monkeypatch: pytest.MonkeyPatch) -> None:
    def through(exemplar: Tensor) -> int:
        hidden = hidden_seams(Exemplar.of(exemplar))
        assert hidden is not None
        count = 0
        for frame in flow.animate(exemplar, flow.vortices(2.0), (128, 128), frames=25, seed=0):
            source = frame.state.source
            column, row = source.round().long()
            deep = torch.from_numpy(hidden.depth)[row.clamp(0, 95), column.clamp(0, 95)] > 0.5
            seams, _ = parted(source, frame.state.inside, turned(source), ((0, 1),))
            count += int((seams[0, :, :-1] & deep[:, :-1] & deep[:, 1:]).sum())
        return count

    monkeypatch.setattr(blocks, "find_cells", lambda _: None)  # the first frame has seams through elements, too
    monkeypatch.setattr(sequence, "cells_that_flow", lambda _: None)
    stones = [MADE["stones"](96, 20, number).image for number in range(2)]
    now = sum(map(through, stones))
    monkeypatch.setattr(sequence, "overlapped", lambda source, *_: source)
    assert now < 0.6 * sum(map(through, stones))
