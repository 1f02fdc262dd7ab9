import sys
from itertools import product

import numpy as np
import pytest
import torch
from bench_elements import cut_elements
from compared import mismatch
from made import MADE

from kwatra import Exemplar
from kwatra.pieces.blocks import BlockStart
from kwatra.pieces.choosing.agreement import DIGITS, FAIR, Agreement
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.seams.mosaic import Mosaic

BLOCK = (6, 5)
IMAGE = np.random.default_rng(0).normal(size=(2, 16, 18))
DEPTH = np.random.default_rng(1).normal(size=(1, 16, 18))


def agreement(hang=(0, 0)):
    exemplar = Exemplar.of(torch.from_numpy(IMAGE).float())
    return Agreement([(IMAGE, 4.0), (DEPTH, 0.5)], Corners.fitting(exemplar, BLOCK, (1, 1)).hanging(hang))


def some_known(boxes):
    """Where boxes' pixels come from, row and column, (2, boxes, *BLOCK), and which are known: in the last none."""
    rng, shape = np.random.default_rng(1), (boxes, *BLOCK)
    place, known = np.stack([rng.integers(0, 16, shape), rng.integers(0, 18, shape)]), rng.random(shape) < 0.6
    known[-1] = False
    return place, known


def by_hand(image, place, known, corner):
    """The summed squares of one block that may hang over, and on how many pixels it was compared."""
    squares, seen = 0.0, 0
    for row, column in np.argwhere(known):
        y, x = corner[0] + row, corner[1] + column
        if 0 <= y < 16 and 0 <= x < 18:
            there = place[:, row, column]
            squares += ((image[:, y, x] - image[:, there[0], there[1]]) ** 2).sum()
            seen += 1
    return squares, seen


@pytest.mark.parametrize("hang", [(0, 0), (2, 3)])
def test_mismatch_is_the_mean_square_over_what_is_known(hang):
    it = agreement(hang)
    place, known = some_known(3)
    valid = np.broadcast_to(it.corners.valid, (3, *it.corners.valid.shape))
    found = mismatch(it, Mosaic([IMAGE]).places_of(list(place)), known, valid)
    corners = it.corners.at(np.arange(valid[0].size))
    for box, (number, (image, variance)) in product(range(2), enumerate([(IMAGE, 4.0), (DEPTH, 0.5)])):
        squares, seen = np.array([by_hand(image, place[:, box], known[box], corner) for corner in corners]).T
        fair = np.quantile(squares / np.maximum(seen, 1), FAIR) if any(hang) else 0.0
        expected = (squares + (known[box].sum() - seen) * fair) / (known[box].sum() * variance)
        np.testing.assert_allclose(found[box, number].ravel(), expected, atol=0.6 * 10**-DIGITS + 2e-6 / variance)
    np.testing.assert_array_equal(found, found.round(DIGITS))
    assert not found[2].any()


def test_blocks_are_chosen_whose_gaps_go_on_though_their_colors_do_not(monkeypatch):
    """Stones of random colors: no block agrees in colors, and nothing else keeps them whole."""

    def torn(aligned, seed):
        monkeypatch.setattr(sys.modules["kwatra.pieces.seams.gaps"], "ALIGNED", aligned)
        made = MADE["stones"](128, 32, seed)
        generator = torch.Generator().manual_seed(2)
        start = BlockStart(Exemplar.of(made.image), (192, 192), (80, 80), (1, 1), generator, usage=0.5, seams=6)
        where = start.run()
        return cut_elements(made.numbers.numpy(), (where[0] * 128 + where[1]).numpy())["cut"]

    whole, anyhow = (np.mean([torn(aligned, seed) for seed in range(4)]) for aligned in (0.5, 0.0))
    assert whole < 0.75 * anyhow
