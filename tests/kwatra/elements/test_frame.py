"""How the frame of a scene grows."""

import numpy as np
import pytest
import torch
from torch import Tensor

from kwatra.elements import grown
from kwatra.elements.frame import LINES, LITTLE

ROWS, TIMES = 64, 20


def scene(*edges: int) -> tuple[Tensor, Tensor, Tensor]:
    """Shares, colors and halves of the time of a video of noise, whose rows are brighter from each of some rows on."""
    noise = 0.1 * torch.rand(1, TIMES, ROWS, 40, generator=torch.Generator().manual_seed(0))
    for edge in edges:
        noise[:, :, edge:] += 1.0
    rows = torch.arange(ROWS).view(1, -1, 1).expand(TIMES, ROWS, 40)
    late = torch.arange(TIMES).view(-1, 1, 1).expand(TIMES, ROWS, 40) >= TIMES // 2
    return (rows / (ROWS - 1)).flatten(), noise.flatten(1), late.flatten()


def lines(share: Tensor) -> np.ndarray:
    """The shares of a video's rows, all of which has to be alike in each."""
    every = share.view(TIMES, ROWS, 40)
    assert torch.equal(every, every[:1, :, :1].expand_as(every))
    return every[0, :, 0].numpy()


def test_what_is_alike_is_stretched_alike():
    share, colors, late = scene()
    there = lines(grown(share, colors, late, 3.0))
    assert np.abs(there - np.arange(ROWS) / (ROWS - 1)).max() < 0.02


@pytest.mark.parametrize("edge", [8, 32])
def test_an_edge_keeps_its_size_wherever_it_is_and_the_rest_fills_the_frame(edge):
    share, colors, late = scene(edge)
    there = lines(grown(share, colors, late, 2.0)) * 2 * ROWS  # in pixels of the larger frame
    steps, size = np.diff(there), ROWS // LINES
    assert (steps > 0).all()
    assert there[0] == 0
    assert there[-1] == 2 * ROWS
    assert steps[edge - size : edge + size - 1].mean() < 1.25
    away = np.r_[steps[: edge - size], steps[edge + size :]]
    assert 1.9 < away.mean() < 2.4


def test_an_edge_of_one_half_of_the_time_is_chance():
    share, colors, late = scene()
    once = colors.view(1, TIMES, ROWS, 40).clone()
    once[:, : TIMES // 2, 16:] += 1.0
    chance, of_a_still = (lines(grown(share, once.flatten(1), when, 2.0)) for when in (late, None))
    assert 1.5 < 2 * ROWS * (chance[16] - chance[15]) < 2.5
    assert 2 * ROWS * (of_a_still[16] - of_a_still[15]) < 1.25


def test_what_grows_little_and_what_is_a_line_stays_as_it_is():
    share, colors, late = scene(32)
    assert torch.equal(grown(share, colors, late, LITTLE), share)
    line = torch.zeros(5)
    assert torch.equal(grown(line, torch.rand(2, 5), None, 4.0), line)
    flat = torch.tensor([0.0, 1.0])
    assert torch.equal(grown(flat, torch.ones(1, 2), None, 4.0), flat)
