"""Parts grow together where what lies between them is weak."""

import numpy as np
import pytest

from kwatra.elements.merging import merged


def borders(parts: np.ndarray, strength: np.ndarray) -> dict[tuple[int, int], float]:
    """How strong on the mean the border between each two parts is."""
    met: dict[tuple[int, int], list[float]] = {}
    for y, x in np.ndindex(parts.shape):
        for other in ((y + 1, x), (y, x + 1)):
            if max(np.subtract(other, parts.shape)) < 0 and 0 < parts[y, x] != parts[other] > 0:
                pair = tuple(sorted((int(parts[y, x]), int(parts[other]))))
                met.setdefault(pair, []).append(max(strength[y, x], strength[other]))
    return {pair: float(np.mean(along)) for pair, along in met.items()}


def one_by_one(parts: np.ndarray, strength: np.ndarray, least: float, speck: float) -> np.ndarray:
    """The same, with all borders looked at anew each time."""
    parts = parts.copy()
    while True:
        area = np.bincount(parts.ravel())
        weak = [
            (strong, pair)
            for pair, strong in borders(parts, strength).items()
            if strong < least or min(area[list(pair)]) < speck
        ]
        if not weak:
            return parts
        kept, gone = min(weak)[1]
        parts[parts == gone] = kept


def alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two pictures are parted in the same way, whatever the numbers."""
    pairs = np.unique(np.stack([one.ravel(), other.ravel()]), axis=1)
    return len(np.unique(pairs[0])) == len(np.unique(pairs[1])) == pairs.shape[1]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("speck", [0, 12])
def test_the_two_with_the_weakest_border_become_one_again_and_again(seed: int, speck: int) -> None:
    rng = np.random.default_rng(seed)
    cells, strength = rng.integers(0, 25, (5, 5)), rng.random((20, 20))
    parts = np.kron(np.arange(1, 26).reshape(5, 5) * (cells > 2), np.ones((4, 4), int))
    for least in (0.3, 0.6, 0.68, 0.72):
        found = merged(parts, strength, least, speck)
        assert alike(found, one_by_one(parts, strength, least, speck))
        assert np.array_equal(found == 0, parts == 0)


def test_a_border_with_a_gap_parts_if_the_rest_is_strong() -> None:
    parts = np.repeat([[1, 2]], 10, 0).repeat(5, 1)
    strength = np.zeros((10, 10))
    strength[:8, 5] = 1.0
    assert len(np.unique(merged(parts, strength, 0.79))) == 2
    assert len(np.unique(merged(parts, strength, 0.81))) == 1


def test_a_speck_is_merged_across_its_weakest_border() -> None:
    parts = np.repeat([[1, 1, 1, 2, 3, 3, 3]], 4, 0)
    strength = np.where(parts == 1, 0.9, np.where(parts == 3, 0.8, 0.0))
    assert np.array_equal(np.unique(merged(parts, strength, 0.5)), [1, 2, 3])
    found = merged(parts, strength, 0.5, 5)
    assert (found[:, 3] == found[:, 4]).all()
    assert (found[:, 2] != found[:, 3]).all()
