import pytest
import torch

from kwatra import Bags, InputError, optimize
from kwatra.source import Bag, Placed


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


COLORS = torch.tensor([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])


def plain(width=4):
    """A bag of four windows of one color each."""
    return COLORS[:, None, None].expand(4, width, width, 3).contiguous()


def test_a_bag_of_four_colors_is_searched_and_read():
    bag = Bag(plain(), torch.ones(3), generator())
    assert bag.count == 4
    assert not isinstance(bag, Placed)
    asked = torch.tensor([[0.9, 0.1, 0.0], [0.1, 0.2, 0.8], [0.7, 0.9, 0.9]])[:, None, None].expand(3, 4, 4, 3)
    described = bag.describe(asked)
    assert bag.nearest(described, 1, "exact")[:, 0].tolist() == [0, 2, 3]
    assert bag.nearest(described, 1, "approximate")[:, 0].tolist() == [0, 2, 3]
    exact = torch.stack([bag.metric.squared(asked - window) for window in plain()], 1)
    assert torch.allclose(bag.estimate(described, bag.numbers.expand(3, 4)), exact, atol=1e-5)
    assert torch.equal(bag.windows(torch.tensor([3, 1])), plain()[[3, 1]])
    inside = (torch.tensor([[3, 0]]), torch.tensor([[1, 2]]))
    assert torch.equal(bag.values(torch.tensor([[1, 3]]), inside)[:, 0], COLORS[[1, 3]].T)


def test_an_image_of_bags_holds_nothing_else():
    texture = Bags({(2, 4): plain(4), (1, 8): plain(8)})
    result = optimize(texture, (24, 20), start="windows")
    assert result.image.shape == (3, 24, 20)
    assert [stage.width for stage in result.stages] == [4, 8]
    assert result.where.shape == result.source.shape == (0, 24, 20)  # there is no canvas to come from
    start = COLORS[0][:, None, None].expand(3, 24, 20) * 0.8
    red = optimize(texture, (24, 20), start=start)
    assert torch.allclose(red.image, COLORS[0][:, None, None].expand(3, 24, 20), atol=1e-3)


def test_bad_bags_are_refused_in_a_sentence():
    with pytest.raises(InputError, match=r"a bag of windows has shape \(0, 4, 4, 3\)"):
        Bag(torch.zeros(0, 4, 4, 3), torch.ones(3), generator())
    with pytest.raises(InputError, match="give finite"):
        Bag(plain() * torch.inf, torch.ones(3), generator())
    with pytest.raises(InputError, match="there is no bag of windows"):
        Bags({})
    with pytest.raises(InputError, match=r"bags have \[3\] channels and 2 weights"):
        Bags({(1, 4): plain()}, torch.ones(2))
    with pytest.raises(InputError, match=r"shape is \(4, 20, 20\); give 2 whole numbers"):
        optimize(Bags({(1, 4): plain()}), (4, 20, 20))
