import itertools

import numpy as np
import pytest
import torch

from kwatra import CheapestSeams, Exemplar, Grid, InputError, Settings, optimize
from kwatra.cut import FREE, KEEP
from kwatra.source import Bag, SourceWindows, heaviest_covering
from kwatra.steps import Ballot, Pull, blend, mean
from kwatra.steps.seamvote import _inner, _Labels


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def setting(shape=(20, 22), width=(8, 8), step=(4, 4)):
    image = torch.nn.functional.avg_pool2d(torch.rand(2, 34, 36, generator=generator()), 3, 1)
    source = SourceWindows(Exemplar.of(image), width, generator())
    grid = Grid(shape, width, step)
    pick = torch.randint(len(source.numbers), (len(grid),), generator=generator(1))
    return source, Ballot(grid, source, source.numbers[pick], torch.rand(len(grid), generator=generator(2)) + 0.1)


def test_one_copy_is_left_as_it_is():
    source, ballot = setting()
    matches = source.snapped(ballot.layout.corners + 3)
    same = Ballot(ballot.layout, source, matches, ballot.weights)
    image = blend(same, vote=CheapestSeams()).x
    assert torch.allclose(image, source.exemplar.canvas[:, 3:23, 3:25], atol=1e-6)


def test_every_pixel_is_copied_from_a_window_that_covers_it_and_has_the_mass_of_all():
    source, ballot = setting()
    pull = CheapestSeams()(ballot)
    assert isinstance(pull, Pull)
    assert torch.allclose(pull.mass, mean(ballot).mass)
    image = pull.value
    windows = source.windows(ballot.matches)
    for y, x in [(0, 0), (7, 11), (19, 21), (10, 4)]:
        shown = []
        for corner, window in zip(ballot.layout.corners.tolist(), windows, strict=True):
            if 0 <= y - corner[0] < 8 and 0 <= x - corner[1] < 8:
                shown.append(window[y - corner[0], x - corner[1]])
        assert min(float((image[:, y, x] - color).abs().max()) for color in shown) < 1e-6


def test_a_window_laid_over_what_stands_is_the_best_of_all_choices():
    source, _ = setting((3, 3), (3, 3), (1, 1))
    labels = _Labels(source, torch.rand(2, 3, 3, generator=generator(3)), 0.5)
    rng = np.random.default_rng(0)
    place = np.indices((3, 3))
    for _ in range(4):
        several, one = rng.integers(2, 20, (2, 3, 3)), rng.integers(2, 20, (2, 1, 1))
        old, new = (flat(labels, corner + place) for corner in (several, one))
        state = np.where(rng.random((3, 3)) < 0.2, KEEP, FREE)
        choices = [np.reshape(c, (3, 3)) & (state == FREE) for c in itertools.product([False, True], repeat=9)]
        best = min(labels.price(np.where(choice, new, old)) for choice in choices)
        assert labels.price(labels.laid(old, new, state)) == best


def flat(labels, where):
    return sum((line + 1) * stride for line, stride in zip(where, labels.mosaic.strides, strict=True))


def test_where_windows_meet_neither_is_taken():
    window = np.array([[0, 0, 0, 1, 1, 1]] * 3 + [[2, 2, 2, 3, 3, 3]] * 2)
    free = _inner(window, np.ones_like(window, bool)) == FREE
    assert free.tolist() == [[True, True, False, False, True, True]] * 2 + [[False] * 6] * 2 + [
        [True, True, False, False, True, True]
    ]


def test_the_sum_is_less_than_that_of_the_heaviest_windows():
    source, ballot = setting()
    labels = _Labels(source, mean(ballot).value, 0.0)
    heaviest = heaviest_covering(ballot.layout, source.metric, ballot.weights)
    places = labels.of(ballot, heaviest.window, list(heaviest.place))
    prices = [labels.price(places)]
    for window, inside, there in ballot.layout.coverings():
        window, there, *inside = torch.broadcast_tensors(window, there, *inside)
        proposed = labels.of(ballot, window, list(inside))
        places = labels.laid(places, proposed, _inner(window.numpy(), there.numpy()))
        prices.append(labels.price(places))
    assert prices == sorted(prices, reverse=True)
    assert prices[-1] < 0.95 * prices[0]


def test_an_optimization_may_vote_by_seams_and_bags_may_not():
    exemplar = Exemplar.of(torch.nn.functional.avg_pool2d(torch.rand(1, 44, 44, generator=generator()), 5, 1))
    image = optimize(exemplar, (40, 40), settings=Settings(vote=CheapestSeams())).image
    nearest = (image.flatten()[:, None] - exemplar.canvas.flatten()).abs().amin(1)
    assert float(nearest.max()) < 1e-6
    bag = Bag(torch.rand(9, 8, 8, 1, generator=generator()), torch.ones(1), generator())
    ballot = Ballot(Grid((16, 16), (8, 8), (4, 4)), bag, torch.zeros(9, dtype=torch.long), torch.ones(9))
    with pytest.raises(InputError, match="windows come from none; vote by mean"):
        CheapestSeams()(ballot)
    with pytest.raises(InputError, match="likeness is -1"):
        CheapestSeams(-1.0)
