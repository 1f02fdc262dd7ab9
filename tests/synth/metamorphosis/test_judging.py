"""The project's own figures of a metamorphosis: films known to be good or bad."""

import pytest
import torch
from pictures import cloud, spots

from kwatra import InputError
from synth.metamorphosis.judging import judge

TIMES = [0, 0.25, 0.5, 0.75, 1]


def true_film() -> list[torch.Tensor]:
    return [cloud(64, 4 - 8 * t, t) for t in TIMES]


def fade(a: torch.Tensor, b: torch.Tensor) -> list[torch.Tensor]:
    return [torch.lerp(a, b, t) for t in TIMES]


def test_a_true_film_is_better_than_a_cross_dissolve():
    film = true_film()
    good, bad = (judge(frames, TIMES, film[0], film[-1]) for frames in (film, fade(film[0], film[-1])))
    assert good["ends"] == bad["ends"] == 0
    assert good["ghost"] < 0.5
    assert bad["ghost"] == pytest.approx(1)
    assert good["near"] < 1.3
    assert good["sharpness"] > 0.9 > bad["sharpness"]
    assert good["overall"] < 0.6 * bad["overall"]


def test_each_fault_shows_in_its_own_figure():
    a, b = spots(64, 0, 0.8), spots(64, 1, 0.3)
    cut = judge([a, a, a, b, b], TIMES, a, b)
    assert cut["steps"] == pytest.approx(4)
    assert cut["progress"] == pytest.approx(0.5, abs=0.01)
    late = judge([b, *fade(a, b)[1:]], TIMES, a, b)
    assert late["ends"] == pytest.approx(float((a - b).abs().mean()), rel=1e-4)
    away = judge([a, a, 1 - a, b, b], TIMES, a, b)
    assert away["near"] > 2
    flicker = [a] + [
        x.roll(shift, (1, 2)) for x, shift in zip(fade(a, b)[1:4], ((9, 20), (30, 7), (17, 40)), strict=True)
    ]
    assert judge([*flicker, b], TIMES, a, b)["coherence"] > 1.5 * judge(fade(a, b), TIMES, a, b)["coherence"]


def test_what_cannot_be_judged_is_refused():
    a = spots(64, 0, 0.8)
    with pytest.raises(InputError, match="at least three"):
        judge([a, a], [0, 1], a, a)
    with pytest.raises(InputError, match="one size"):
        judge([a, a[:, :40], a], [0, 0.5, 1], a, a)
