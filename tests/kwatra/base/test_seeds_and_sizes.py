"""Any seed makes a generator of its own; sizes are whole numbers of any type."""

import numpy as np
import pytest
import torch

import flow
import kwatra
from kwatra import Exemplar, InputError
from kwatra.base import generator_of, is_whole, whole_sizes
from synth.quilting import QuiltSettings, quilt


def draw(seed: int, step: int = 0) -> float:
    return float(torch.rand(1, generator=generator_of(seed, step), dtype=torch.float64))


def texture(side: int = 24) -> torch.Tensor:
    return torch.rand(1, side, side, generator=torch.Generator().manual_seed(0))


def test_small_seeds_are_taken_as_they_are() -> None:
    for seed in (0, 1, 7, 2**32 - 1):
        expected = torch.rand(1, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        assert draw(seed) == float(expected)
    assert draw(np.int64(7)) == draw(7)


def test_seeds_and_steps_of_any_size_differ() -> None:
    seeds = [0, 5, 5 + 2**32, 5 + 2**64, 10**40]
    assert len({draw(seed) for seed in seeds}) == len(seeds)
    steps = [(seed, step) for seed in seeds for step in (0, 1, 2)]
    assert len({draw(*each) for each in steps}) == len(steps)


@pytest.mark.parametrize("seed", [-1, 1.5, None, "7", float("nan")])
def test_other_seeds_are_refused(seed: object) -> None:
    with pytest.raises(InputError, match="give a whole number from 0 on"):
        generator_of(seed)


def test_large_seeds_reach_everything_that_draws() -> None:
    seed, exemplar = 2**64 + 3, Exemplar.of(texture())
    quick = kwatra.Settings(iterations=1)
    kwatra.optimize(exemplar, (16, 16), settings=quick, seed=seed)
    quilt(texture(), (30, 30), QuiltSettings(seed=seed, refine=1))
    assert len(list(flow.animate(exemplar, flow.uniform(1.0), (24, 24), frames=2, seed=seed, synthesis=quick))) == 2
    assert len(list(flow.loop(exemplar, flow.uniform(1.0), (24, 24), frames=2, seed=seed, synthesis=quick))) == 2
    flow.noise(seed=seed)(0.0, (8, 8))


@pytest.mark.parametrize("sizes", [(24.0, 24.0), np.array([24, 24]), torch.Size([24, 24])])
def test_whole_numbers_of_other_types_are_sizes(sizes: object) -> None:
    assert whole_sizes(sizes, 2) == (24, 24)
    assert kwatra.optimize(Exemplar.of(texture()), sizes).image.shape == (1, 24, 24)
    assert quilt(texture(), sizes, QuiltSettings(refine=0)).image.shape == (1, 24, 24)


@pytest.mark.parametrize("sizes", [(24.5, 24), (24,), (0, 24), (float("nan"), 24), (float("inf"), 24), ("a", 24), 24])
def test_other_sizes_are_refused_at_once(sizes: object) -> None:
    with pytest.raises(InputError, match="give 2 whole numbers of pixels, each at least 1"):
        kwatra.optimize(Exemplar.of(texture()), sizes)


@pytest.mark.parametrize(
    ("value", "whole"), [(3, True), (3.0, True), (np.int8(3), True), (torch.tensor(2), True), (1, False), (2.5, False)]
)
def test_whole_numbers_are_told_from_others_and_from_too_small_ones(value: object, whole: bool) -> None:
    assert is_whole(value, 2) == whole
    for other in (float("nan"), float("inf"), "three", None, (3, 4)):
        assert not is_whole(other, 2)


def test_negative_weights_of_a_term_are_refused() -> None:
    weight = torch.full((1, 24, 24), 0.5)
    weight[0, 3, 3] = -0.1

    class Bent:
        name = "bent"

        def at(self, factor: object, shape: object) -> "Bent":
            return self

        def energy(self, x: torch.Tensor) -> float:
            return 0.0

        def quadratic(self, x: torch.Tensor) -> kwatra.Quadratic:
            return kwatra.Quadratic(weight, torch.zeros(1, 24, 24))

    with pytest.raises(InputError, match="the term 'bent' has negative weights"):
        kwatra.optimize(Exemplar.of(texture()), (24, 24), terms=Bent())
