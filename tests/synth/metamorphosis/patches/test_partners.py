"""Which neighborhoods correspond: brute force, and a transport that uses all alike."""

import torch

from kwatra.source import Bag
from synth.metamorphosis.patches.correspondence import nearest, transported


def bag(windows: torch.Tensor) -> Bag:
    return Bag(windows, torch.ones(2), torch.Generator().manual_seed(0))


def some(count: int, seed: int) -> torch.Tensor:
    return torch.rand(count, 3, 3, 2, generator=torch.Generator().manual_seed(seed))


def test_nearest_is_nearest() -> None:
    own, other = bag(some(40, 0)), bag(some(60, 1))
    root = own.metric.root
    apart = torch.cdist((own.windows(own.numbers) * root).flatten(1), (other.windows(other.numbers) * root).flatten(1))
    assert torch.equal(nearest(own.windows(own.numbers), other), apart.argmin(1))


def test_the_same_windows_in_another_order_are_found_by_transport() -> None:
    windows, order = some(50, 0), torch.randperm(50, generator=torch.Generator().manual_seed(2))
    there, back = transported(bag(windows), bag(windows[order]))
    assert torch.equal(order[there], torch.arange(50))
    assert torch.equal(there[back], torch.arange(50))


def test_transport_uses_all_where_nearest_leaves_some_out() -> None:
    # one window of the second set is near to all of the first, and the nearest of each
    first = 0.5 + 0.2 * (some(30, 0) - 0.5)
    second = torch.cat([first.mean(0, keepdim=True), first[1:] + 0.15])
    own, other = bag(first), bag(second)
    by_nearest = nearest(first, other)
    there, _ = transported(own, other)
    assert len(there.unique()) > 2 * len(by_nearest.unique())
