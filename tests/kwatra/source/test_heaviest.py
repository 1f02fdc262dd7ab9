import numpy as np
import pytest
import torch

from kwatra import Grid
from kwatra.source import heaviest_covering
from kwatra.windows import Metric


@pytest.mark.parametrize(
    ("shape", "width", "step", "wraps"),
    [
        ((33, 41), (8, 8), (2, 2), False),
        ((33, 41), (8, 16), (4, 8), (True, False)),
        ((9, 20, 21), (4, 8, 8), (1, 4, 2), (True, False, True)),
    ],
)
def test_the_first_of_the_windows_that_weigh_most(shape, width, step, wraps):
    layout, metric = Grid(shape, width, step, wraps), Metric(width, torch.ones(3), ())
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
    assert torch.equal(torch.stack(found.inside), expected[2:])
    assert bool(found.there.all())
