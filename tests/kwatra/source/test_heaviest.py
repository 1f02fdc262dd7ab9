import numpy as np
import pytest
import torch

from kwatra import FreeWindows, Grid
from kwatra.source import heaviest_covering
from kwatra.windows import Metric


@pytest.mark.parametrize(
    "layout",
    [
        Grid((33, 41), (8, 8), (2, 2)),
        Grid((33, 41), (8, 16), (4, 8), (True, False)),
        Grid((9, 20, 21), (4, 8, 8), (1, 4, 2), (True, False, True)),
        FreeWindows((13, 11), (8, 6), torch.tensor([[0, 0], [5, 5], [5, 2], [3, 0], [0, 5], [4, 4], [5, 0]])),
    ],
)
def test_the_first_of_the_windows_that_weigh_most(layout):
    shape, metric = layout.shape, Metric(layout.width, torch.ones(3), ())
    weights = torch.rand(len(layout), generator=torch.Generator().manual_seed(0)).round(decimals=1)  # many are equal
    found = heaviest_covering(layout, metric, weights)
    axes = range(len(shape))
    profiles = [metric.falloff.sum([axis for axis in range(metric.falloff.ndim) if axis != own]) for own in axes]
    every = []
    for window, inside, there in layout.coverings():
        share = torch.ones(())
        for profile, place in zip(profiles, inside, strict=True):
            share = share * profile[place]
        parts = torch.broadcast_tensors(torch.where(there, weights[window] * share, -1.0), window, *inside)
        every.append(torch.stack([part.double() for part in parts]))
    first = torch.from_numpy(np.stack([each[0] for each in every]).argmax(0))
    expected = torch.stack(every).gather(0, first[None, None].expand(1, len(shape) + 2, *shape))[0].long()
    assert torch.equal(found.window, expected[1])
    assert torch.equal(found.place, expected[2:])
    corners = torch.randint(50, layout.corners.shape, generator=torch.Generator().manual_seed(1))
    counted = heaviest_covering(layout, metric, weights, corners)
    assert torch.equal(counted.window, found.window)
    assert torch.equal(counted.place - found.place, corners[found.window].movedim(-1, 0))
