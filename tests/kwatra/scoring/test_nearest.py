"""The windows of images, and the nearest of them: against brute force."""

import sys

import pytest
import torch
import torch.nn.functional as F
from textures import gravel, noise

from kwatra.scoring.nearest import SAMPLE, Nearest, Projection, Windows


@pytest.mark.parametrize("scale", [1, 2, 4])
def test_a_window_of_a_scale_is_the_window_of_the_shrunk_image(scale: int) -> None:
    image = noise(2, 28, 32)
    shrunk = F.avg_pool2d(image, scale)
    number = torch.tensor([0])
    coarse = Windows.of([image], 7, scale).rows(number)
    assert torch.equal(coarse, Windows.of([shrunk], 7).rows(number))


def test_windows_of_several_images_are_numbered_one_image_after_another() -> None:
    images = [noise(2, 9, 12), noise(2, 11, 8, seed=1)]
    windows = Windows.of(images, 7)
    unfolded = torch.cat([F.unfold(image[None], 7)[0].T for image in images])
    assert torch.equal(windows.rows(torch.arange(len(windows))), unfolded)


@pytest.mark.parametrize("scale", [1, 2, 4])
def test_coordinates_by_convolution_are_those_of_the_rows(scale: int) -> None:
    image = 5 + noise(3, 40, 44)
    windows = Windows.of([image], 7, scale)
    rows = windows.rows(torch.arange(len(windows)))
    project = Projection.learned_from(rows)
    everywhere = project.all_windows(windows.videos[0], windows)
    assert torch.allclose(everywhere, project(rows), atol=1e-4)


def test_a_sample_is_of_the_size_asked_for_and_without_repetition() -> None:
    windows = Windows.of([noise(1, 60, 90), noise(1, 40, 30)], 7)
    sample = windows.sample(500)
    assert 450 < len(sample) < 620
    assert len(sample.unique()) == len(sample)
    assert int(sample.max()) < len(windows)


@pytest.mark.parametrize("side", [40, 110], ids=["exhaustive", "by lists"])
def test_nearest_distances_agree_with_brute_force(side: int) -> None:
    exemplar, output = gravel(side, shrunk=2), gravel(220, shrunk=2)[:, 160:190, 160:190]
    windows = Windows.of([exemplar], 7)
    assert (len(windows) > SAMPLE) == (side == 110)
    queries = F.unfold(output[None], 7)[0].T
    others = F.unfold(exemplar[None], 7)[0].T
    brute = torch.cdist(queries.double(), others.double()).min(1).values / 7
    found, number = Nearest(windows).search(queries)
    assert (found >= brute - 1e-5).all()
    assert float(found.mean()) == pytest.approx(float(brute.mean()), rel=0.01)
    real = (others[number] - queries).square().mean(1).sqrt()
    assert torch.allclose(found, real, atol=1e-6)


@pytest.mark.parametrize("side", [30, 110], ids=["of few windows", "by lists"])
def test_what_was_learned_from_windows_much_the_same_serves_to_search(side: int) -> None:
    image = gravel(220, shrunk=2)
    like, windows = Nearest(Windows.of([image[:, :side, :side]], 7), components=12), Windows.of([image[:, 100:]], 7)
    queries = Windows.of([image[:, :30, 110:140]], 7).rows(torch.arange(24 * 24))
    assert len(windows) > SAMPLE
    best, _ = Nearest(windows).search(queries)
    found, number = Nearest(windows, like).search(queries)
    assert float(found.mean()) == pytest.approx(float(best.mean()), rel=0.02)
    assert torch.allclose(found, (windows.rows(number) - queries).square().mean(1).sqrt(), atol=1e-6)


def test_a_large_set_is_searched_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    windows = Windows.of([noise(1, 40, 40)], 7)
    queries = windows.rows(torch.tensor([0, 700, 1155]))
    whole = Nearest(windows).search(queries)
    monkeypatch.setattr(sys.modules[Nearest.__module__], "PART", 100)
    nearest = Nearest(windows)
    for _ in range(2):
        parts = nearest.search(queries)
        assert torch.equal(whole[0], parts[0])
        assert parts[1].tolist() == [0, 700, 1155]
