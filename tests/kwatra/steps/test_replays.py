"""Copies that run on in time, and what they are charged."""

import pytest
import torch

from kwatra import Exemplar, Settings, Stay, optimize
from kwatra.source import SourceWindows
from kwatra.steps import Replays
from kwatra.steps.replays import LONGEST, PRICE
from kwatra.windows import Grid


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def setting(wraps=False, depth=4, step=1, frames=16, run=6):
    clip = torch.rand(1, 24, 12, 12, generator=generator())
    source = SourceWindows(Exemplar.of(clip), (depth, 4, 4), generator())
    grid = Grid((frames, 8, 6), (depth, 4, 4), (step, 2, 2), wrap=(wraps, False, False))
    pieces = torch.arange(frames).div(run, rounding_mode="floor")[grid.corners[:, 0]]
    matches = source.snapped(grid.corners + torch.stack([pieces * 3, pieces % 2, pieces], 1))
    return source, grid, matches


def charged(source, grid, matches, there):
    """Window by window, by walking forward and backward: which (N, k) are in a copy of more than LONGEST frames."""
    number = {tuple(corner): at for at, corner in enumerate(grid.corners.tolist())}
    places, step, period = source.corners(matches).tolist(), grid.step[0], grid.shape[0]
    result = torch.zeros(there.shape[:2])
    for at, corner in enumerate(grid.corners.tolist()):
        for k, place in enumerate(there[at].tolist()):
            frames = grid.width[0]
            for sign in (-step, step):
                for steps in range(1, 20):
                    t = corner[0] + sign * steps
                    beside = number.get((t % period if grid.wraps[0] else t, *corner[1:]))
                    if beside is None or places[beside] != [place[0] + sign * steps, *place[1:]]:
                        break
                    frames += step
            result[at, k] = frames > LONGEST
    return result


@pytest.mark.parametrize(("wraps", "depth", "step"), [(False, 4, 1), (True, 4, 1), (False, 6, 1), (False, 6, 2)])
@pytest.mark.parametrize(("frames", "run"), [(16, 6), (17, 6), (16, 5)])  # windows of 4 on 5 places have 8 frames
def test_windows_pay_that_make_a_copy_of_more_frames_than_are_free(wraps, depth, step, frames, run):
    source, grid, matches = setting(wraps, depth, step, frames, run)
    shifts = torch.tensor([[0, 0, 0], [3, 1, 1], [-3, -1, -1], [6, 0, 2], [1, 0, 0]])
    there = source.corners(matches)[:, None] + shifts
    expected = charged(source, grid, matches, there)
    assert 0.02 < float(expected.mean()) < 0.98
    replays = Replays(grid, source, matches)
    assert replays.price == pytest.approx(PRICE / 12, rel=0.05)  # of values that are spread evenly from 0 to 1
    assert torch.equal(replays(grid.corners, there), replays.price * expected)
    some = torch.randperm(len(grid), generator=generator(1))[:50]
    assert torch.equal(replays(grid.corners[some], there[some]), replays.price * expected[some])


def test_charges_are_single_where_numbers_are_doubles_unless_told():
    """They are added to squared distances, and weights would be doubles."""
    source, grid, matches = setting()
    torch.set_default_dtype(torch.float64)
    try:
        charges = Replays(grid, source, matches)(grid.corners, source.corners(matches)[:, None])
    finally:
        torch.set_default_dtype(torch.float32)
    assert charges.dtype == torch.float32


def test_videos_in_their_place_are_charged_for_long_copies_and_others_are_not(monkeypatch):
    charges = []
    monkeypatch.setattr("kwatra.loop.scene.Replays", lambda *given: charges.append(Replays(*given)) or charges[-1])
    exemplar = Exemplar.of(torch.rand(1, 12, 24, 24, generator=generator()))
    optimize(exemplar, (12, 24, 24), settings=Settings(iterations=2))
    assert not charges
    optimize(exemplar, (12, 24, 24), settings=Settings(iterations=2), terms=Stay(0.3))
    assert charges
