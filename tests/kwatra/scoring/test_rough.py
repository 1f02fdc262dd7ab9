"""Figures that are rough, or of pictures too small for the others: they must rank as those do."""

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
import torch
from textures import gravel
from torch import Tensor

from kwatra.scoring import Ranking, glance, measure, rough
from kwatra.scoring.nearest import Nearest, Windows
from kwatra.scoring.rough import GLANCES, MOST


def controls(image: Tensor) -> list[Tensor]:
    """The image with more and more noise: each worse than the one before."""
    noise = torch.rand(image.shape, generator=torch.Generator().manual_seed(0)) - 0.5
    return [image + level * noise for level in (0.1, 0.3, 0.9)]


def test_a_glance_ranks_as_the_measure_does_and_is_near_it() -> None:
    image = gravel(96, shrunk=2)
    rough = [glance(other, image) for other in controls(image)]
    whole = [measure(other, image)["overall"] for other in controls(image)]
    assert rough == sorted(rough)
    assert rough == pytest.approx(whole, rel=0.3)
    assert glance(image, image) == pytest.approx(0, abs=1e-6)


def test_of_a_large_image_a_glance_sees_the_middle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kwatra.scoring.rough.MOST", 48)
    image = gravel(96, shrunk=2)
    other = torch.zeros_like(image)
    other[:, 24:72, 24:72] = image[:, 24:72, 24:72]
    assert glance(other, image) == pytest.approx(0, abs=1e-6)
    assert (GLANCES, MOST) == (300, 1024)


@pytest.mark.parametrize("side", [1, 3, 6, 40])
def test_pictures_of_any_size_are_ranked(side: int) -> None:
    image = gravel(64, shrunk=2)[:, :side, :side]
    same, other = Ranking(image)(image), Ranking([image, image])(1 - image)
    assert same == pytest.approx(0, abs=1e-6)
    assert other > 0.05


def test_of_many_channels_the_first_are_ranked_and_images_at_a_glance() -> None:
    image = gravel(24, shrunk=2)
    many = torch.cat([image.expand(16, -1, -1), torch.rand(48, 24, 24, generator=torch.Generator().manual_seed(1))])
    assert Ranking(image.expand(64, -1, -1))(many) == pytest.approx(0, abs=1e-6)
    figure = Ranking(image)
    assert [figure(other) for other in controls(image)] == [glance(other, image) for other in controls(image)]


def test_an_exemplar_that_was_described_is_not_described_again(monkeypatch: pytest.MonkeyPatch) -> None:
    image, made = gravel(96, shrunk=2), []
    described = rough._Sight.__init__
    monkeypatch.setattr(rough._Sight, "__init__", lambda *sight: made.append(sight[2]) or described(*sight))
    figure = Ranking(image)
    figure.describe((1, 48, 64))
    assert len(made) == 1
    assert figure(image[:, :48, :64]) == Ranking(image)(image[:, :48, :64])
    assert len(made) == 2  # the second is the other ranking's


def test_threads_that_search_a_large_set_at_once_find_what_each_finds_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[Nearest.__module__], "PART", 400)
    windows = Windows.of([torch.rand(1, 60, 60, generator=torch.Generator().manual_seed(0))], 7)
    nearest, queries = Nearest(windows), windows.rows(torch.arange(0, len(windows), 9))
    alone = nearest.search(queries)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(nearest.search, [queries] * 24):
            assert torch.equal(found[0], alone[0])
            assert torch.equal(found[1], alone[1])
