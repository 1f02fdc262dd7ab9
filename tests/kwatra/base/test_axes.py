"""What lies in windows, against brute force."""

import numpy as np
import pytest
import torch

from kwatra.base import running


@pytest.mark.parametrize("width", [(1, 1), (2, 3), (5, 7), (8, 4), (9, 11)])
def test_the_largest_and_least_of_every_window_are_found(width):
    values = torch.rand(9, 11, generator=torch.Generator().manual_seed(0))
    windows = np.lib.stride_tricks.sliding_window_view(values.numpy(), width)
    assert np.array_equal(running(torch.maximum, values, width).numpy(), windows.max((-2, -1)))
    assert np.array_equal(running(torch.minimum, values, width).numpy(), windows.min((-2, -1)))
