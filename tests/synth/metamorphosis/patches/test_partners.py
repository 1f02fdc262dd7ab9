"""Which neighborhoods correspond: brute force, and a transport that uses all alike."""

import pytest
import torch

from kwatra.source import Bag
from synth.metamorphosis.patches.correspondence import nearest, transported
from synth.metamorphosis.patches.model import Making, matched


def bag(windows: torch.Tensor) -> Bag:
    return Bag(windows, torch.ones(2), torch.Generator().manual_seed(0))


def some(count: int, seed: int) -> torch.Tensor:
    return torch.rand(count, 3, 3, 2, generator=torch.Generator().manual_seed(seed))


def test_nearest_is_nearest() -> None:
    own, other = bag(some(40, 0)), bag(some(60, 1))
    root = own.metric.root
    apart = torch.cdist((own.windows(own.numbers) * root).flatten(1), (other.windows(other.numbers) * root).flatten(1))
    assert torch.equal(nearest(own.windows(own.numbers), other, 3), apart.topk(3, largest=False).indices)


def test_the_same_windows_in_another_order_are_found_by_transport() -> None:
    windows, order = some(50, 0), torch.randperm(50, generator=torch.Generator().manual_seed(2))
    there, back = (found[:, 0] for found in transported(bag(windows), bag(windows[order]), 2))
    assert torch.equal(order[there], torch.arange(50))
    assert torch.equal(there[back], torch.arange(50))


def test_transport_uses_all_where_nearest_leaves_some_out() -> None:
    # one window of the second set is near to all of the first, and the nearest of each
    first = 0.5 + 0.2 * (some(30, 0) - 0.5)
    second = torch.cat([first.mean(0, keepdim=True), first[1:] + 0.15])
    own, other = bag(first), bag(second)
    by_nearest = nearest(first, other, 1)
    there, _ = transported(own, other, 1)
    assert len(there.unique()) > 2 * len(by_nearest.unique())


@pytest.mark.parametrize("transport", [True, False])
def test_every_window_has_k_different_partners_in_each_other_texture(transport: bool) -> None:
    images = [torch.rand(1, 24, 24, generator=torch.Generator().manual_seed(seed)) for seed in range(3)]
    maps = [image[0] > 0.8 for image in images]
    making = Making(partners=3, transport=transport, anchors=30, warped=False)
    found = matched(images, maps, (1.0, 1.0, 1.0), (1, 9), making).neighborhoods
    each = found.centers.view(-1, 3, 3, 2)  # windows, partners, textures
    for number, centers in enumerate(each):
        own = int(found.anchor[3 * number])
        assert torch.equal(centers[0, own], centers[1, own])
        assert all(len(centers[:, other].unique(dim=0)) == 3 for other in range(3) if other != own)
