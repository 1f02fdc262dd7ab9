"""Pictures that repeat but for noise go on in step, however few and however oblique their periods are."""

import math

import numpy as np
import pytest
import torch

from kwatra import Exemplar, begin

SIDE = 100


def oblique(seed):
    """A noisy picture (3, SIDE, SIDE) of cells of some 70 px, turned by some 40 degrees, and its vectors (2, 2)."""
    rng = np.random.default_rng(seed)
    turn, sides = math.radians(rng.uniform(35, 50)), rng.uniform(66, 76, (2, 1))
    vectors = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]) * sides
    ways = np.stack(np.indices((SIDE, SIDE)), -1) @ np.linalg.inv(vectors)
    image = rng.normal(size=(3, SIDE, SIDE)) * 0.05
    for waves in np.indices((7, 7)).reshape(2, -1).T - 3:
        turns = 2 * math.pi * (ways @ waves) + rng.uniform(0, 2 * math.pi, (3, 1, 1))
        image += math.exp(-(waves @ waves) / 6) * rng.normal(size=(3, 1, 1)) * np.cos(turns)
    return torch.from_numpy(image).float(), vectors


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_picture_of_few_oblique_periods_goes_on_in_step(seed):
    image, vectors = oblique(seed)
    where = begin(Exemplar.of(image), (200, 200), seed=seed).where
    assert where is not None
    cells = np.linalg.inv(vectors).T @ (np.indices((200, 200)) - where.numpy()).reshape(2, -1)
    away = cells - cells[:, :1]
    assert (np.hypot(*(vectors.T @ (away - away.round()))) < 3).mean() > 0.99
