"""Surfaces of given steps: against a dense solution, and what follows from their definition."""

import numpy as np
import pytest
import torch
from torch import Tensor

from kwatra.base import every_pair, membrane


def asked(seed: int = 0, shape: tuple[int, ...] = (7, 6)) -> tuple[Tensor, list[Tensor], list[Tensor], Tensor]:
    """Free pixels, pairs, steps and fixed values at random, of some shape and two channels; axis 0 is closed."""
    random = torch.Generator().manual_seed(seed)
    free = torch.rand(*shape, generator=random) < 0.7
    pairs = [(torch.rand(*shape, generator=random) < 0.8).float() for _ in shape]
    for axis, pair in enumerate(pairs[1:], 1):
        pair.select(axis, -1).zero_()
    steps = [torch.randn(2, *shape, generator=random) for _ in shape]
    return free, pairs, steps, torch.randn(2, *shape, generator=random)


def dense(free: Tensor, pairs: list[Tensor], steps: list[Tensor], reach: float, fixed: Tensor) -> np.ndarray:
    """The same by least squares over all equations written out."""
    place = {at: number for number, at in enumerate(zip(*np.nonzero(free.numpy()), strict=True))}
    found = np.zeros(fixed.shape)
    for channel in range(len(fixed)):
        rows, rights = [np.eye(len(place)) / reach], [np.zeros(len(place))]
        for axis in range(free.ndim):
            for here in np.ndindex(*free.shape):
                after = list(here)
                after[axis] = (after[axis] + 1) % free.shape[axis]
                row, right = np.zeros(len(place)), float(steps[axis][(channel, *here)])
                for at, sign in ((tuple(after), 1.0), (here, -1.0)):
                    if at in place:
                        row[place[at]] += sign
                    else:
                        right -= sign * float(fixed[(channel, *at)])
                weight = float(pairs[axis][here])
                if row.any():
                    rows.append(weight * row[None])
                    rights.append(np.array([weight * right]))
        surface = np.linalg.lstsq(np.concatenate(rows), np.concatenate(rights), rcond=None)[0]
        for at, number in place.items():
            found[(channel, *at)] = surface[number]
    return found


@pytest.mark.parametrize(("seed", "reach", "shape"), [(0, 3.0, (7, 6)), (1, 1.0, (4, 5, 3)), (2, 50.0, (7, 6))])
def test_it_is_the_least_squares_solution(seed: int, reach: float, shape: tuple[int, ...]) -> None:
    free, pairs, steps, fixed = asked(seed, shape)
    zero = [torch.where(free & free.roll(-1, axis), step, 0.0) for axis, step in enumerate(steps)]
    found = membrane(free, pairs, zero, reach, fixed)
    np.testing.assert_allclose(found.numpy(), dense(free, pairs, zero, reach, fixed), atol=5e-3)
    bare = membrane(free, pairs, steps, reach)
    np.testing.assert_allclose(bare.numpy(), dense(free, pairs, steps, reach, torch.zeros_like(fixed)), atol=5e-3)


def test_values_go_on_over_the_reach_and_not_where_pixels_are_not_paired() -> None:
    free = torch.ones(1, 60, dtype=torch.bool)
    free[0, 0] = False
    pairs = [torch.zeros(1, 60), torch.ones(1, 60)]
    pairs[1][0, 40:] = 0
    found = membrane(free, pairs, [torch.zeros(1, 1, 60)] * 2, 10.0, torch.ones(1, 1, 60))[0, 0]
    assert float(found[11] / found[1]) == pytest.approx(np.exp(-1), abs=0.03)
    assert float(found[0]) == float(found[41:].abs().max()) == 0


def test_nothing_is_added_where_nothing_rises() -> None:
    free, pairs, steps, _ = asked()
    assert not membrane(free, pairs, [torch.zeros_like(step) for step in steps], 5.0).any()


def test_every_pixel_is_paired_with_the_next_and_the_last_with_the_first_where_that_is_closed() -> None:
    down, across = every_pair((3, 4), (True, False))
    assert down.tolist() == [[1.0] * 4] * 3
    assert across.tolist() == [[1.0, 1.0, 1.0, 0.0]] * 3
    assert [int(pair.sum()) for pair in every_pair((3, 4, 5))] == [2 * 4 * 5, 3 * 3 * 5, 3 * 4 * 4]
    down, across = every_pair((3, 4))
    assert down.tolist() == [[1.0] * 4, [1.0] * 4, [0.0] * 4]
    assert across.tolist() == [[1.0, 1.0, 1.0, 0.0]] * 3
