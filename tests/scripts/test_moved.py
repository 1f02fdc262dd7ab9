"""Elements that are moved exactly."""

import numpy as np
import torch
from moved import exactly_moved

import flow


def four() -> np.ndarray:
    """Four squares of 6x6 pixels around the middle of 40x40."""
    numbers = np.zeros((40, 40), dtype=np.int64)
    for number, (row, column) in enumerate([(12, 12), (12, 22), (22, 12), (22, 22)], 1):
        numbers[row : row + 6, column : column + 6] = number
    return numbers


def shown(field: flow.Field, at: list[int]) -> list[np.ndarray]:
    numbers = four()
    return [numbers.flat[frame] for frame in exactly_moved(numbers, field, (20, 20), at)]


def test_a_uniform_flow_shifts_the_picture() -> None:
    first, later = shown(flow.uniform(2.0, angle=0), [0, 3])
    assert np.array_equal(first, four()[10:30, 10:30])
    assert np.array_equal(later, four()[10:30, 4:24])


def test_elements_keep_their_shape_in_a_rotation() -> None:
    _, later = shown(flow.rotation(1.0), [0, 8])
    for number in range(1, 5):
        rows, columns = np.nonzero(later == number)
        assert (len(rows), np.ptp(rows), np.ptp(columns)) == (36, 5, 5)
    assert not np.array_equal(later, four()[10:30, 10:30])


def test_of_elements_that_overlap_the_deeper_is_seen() -> None:
    def together(number: float, shape: tuple[int, int]) -> torch.Tensor:
        x = torch.arange(shape[1]).expand(shape)
        return torch.stack([torch.where(x < shape[1] / 2, 1.0, -1.0), torch.zeros(shape)])

    (later,) = shown(flow.Field(together), [4])  # 4 columns of 6 overlap: each has those it is deeper in
    row = later[4]
    assert row.tolist() == [0] * 6 + [1] * 4 + [2] * 4 + [0] * 6
    assert set(np.unique(later)) == {0, 1, 2, 3, 4}
