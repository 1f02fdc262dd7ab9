"""Detection on made textures whose patterns are known, and what draws its line."""

import numpy as np
import pytest
from bench_patterns import made, measured

from synth.metamorphosis.patterns import detect
from synth.metamorphosis.patterns.detection import _moved, _single


@pytest.mark.parametrize(("kind", "noise"), [("disc", 0.08), ("cross", 0.08), ("cross", 0.15)])
def test_patterns_in_noise_are_found_with_their_landmarks(kind: str, noise: float) -> None:
    figures = measured(kind, seed=1, noise=noise)
    assert figures["found"] >= 0.95 * figures["there"]
    assert figures["wrong"] <= 0.05 * figures["found"]
    assert figures["worst"] < 1


def test_landmarks_lie_between_pixels_where_the_look_is_best_there() -> None:
    least = np.array([[7.3, 9.0], [12.4, 5.8], [15.0, 11.0]])
    y, x = np.mgrid[:20, :24]
    looks = np.stack([0.01 * (x - cx) ** 2 + 0.02 * (y - cy) ** 2 for cx, cy in least])
    moved = _moved(looks, np.rint(least)[None] + 1, 3)
    np.testing.assert_allclose(moved[0], least, atol=1e-9)
    flat = _moved(np.zeros_like(looks), least[None], 2)
    assert np.isfinite(flat).all()


def test_votes_peak_where_the_patterns_are() -> None:
    texture = made("disc", seed=2, size=120)
    detection = detect(texture.image, texture.landmarks[0])
    x, y = np.rint(texture.landmarks.mean(1)).astype(int).T
    assert detection.votes[y, x].min() > 3 * np.median(detection.votes)


def test_a_threshold_that_is_given_is_kept() -> None:
    texture = made("cross", seed=3, size=120)
    every = detect(texture.image, texture.landmarks[0], threshold=2.0)
    few = detect(texture.image, texture.landmarks[0], threshold=0.5)
    assert every.distances.max() <= 2
    assert 0 < len(few.landmarks) < len(every.landmarks)
    assert few.distances.max() <= 0.5
    assert np.all(np.diff(every.distances) >= 0)


def test_the_same_image_shifted_has_the_same_patterns_shifted() -> None:
    texture = made("cross", seed=4)
    own, shift = texture.landmarks[len(texture.landmarks) // 2], np.array([5, 3])
    here = detect(texture.image, own).landmarks.mean(1)
    there = detect(texture.image[3:, 5:], own - shift).landmarks.mean(1) + shift
    inner = here[((here > 30) & (here < 170)).all(1)]
    away = np.linalg.norm(inner[:, None] - there[None], axis=2).min(1)
    assert len(inner) > 10
    assert away.max() < 1


def test_of_patterns_that_lie_in_each_other_one_is_kept_and_neighbors_are() -> None:
    half = np.array([[-8, -3], [0, -3], [8, -3], [8, 3], [0, 3], [-8, 3]], float)
    places = np.array([[0, 0], [8, 0], [17, 0], [0, 7], [1, 3], [33, 0]], float)
    kept, far = _single(places[:, None] + half, np.array([0.1, 0.3, 0.2, 0.2, 0.4, 0.1]))
    assert {tuple(center) for center in kept.mean(1)} == {(0, 0), (17, 0), (0, 7), (33, 0)}
    assert far.tolist() == [0.1, 0.1, 0.2, 0.2]
    upright = half[:, ::-1]
    kept, _ = _single(np.array([[0, 0], [7, 0], [0, 8]], float)[:, None] + upright, np.arange(3.0))
    assert {tuple(center) for center in kept.mean(1)} == {(0, 0), (7, 0)}
    line = np.array([[-8, 0], [0, 0], [8, 0]], float)
    kept, _ = _single(np.array([[0, 0], [0, 2], [0, 6]], float)[:, None] + line, np.arange(3.0))
    assert {tuple(center) for center in kept.mean(1)} == {(0, 0), (0, 6)}
