"""What a caller has set of torch is the caller's: results are the same bits, and nothing fails.

That is whether derivatives may be taken, and of what type numbers are that are given none.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
import torch
from skimage import data

import flow
import synth
from kwatra import Feature, gradient
from kwatra.windows.metric import Metric
from synth.quilting import QuiltSettings, quilt

GRAVEL, BRICK = data.gravel()[:32, :36], data.brick()[:32, :36]
HOLE = np.zeros(GRAVEL.shape, bool)
HOLE[10:18, 12:22] = True


TENSOR = torch.from_numpy(GRAVEL / 255).float()[None]
CLIP = np.stack([np.roll(GRAVEL, t, 0) for t in range(6)])[..., None]


def morphed(method: str) -> Sequence[np.ndarray]:
    return synth.morph(GRAVEL, BRICK, 3, method=method, preset="fast").frames


def animated(exemplar: torch.Tensor) -> Sequence[torch.Tensor]:
    return [frame.image for frame in flow.animate(exemplar, flow.rotation(1.5), (32, 36), frames=3)]


PROGRAMS: dict[str, Callable[[], Any]] = {
    "synthesize": lambda: synth.synthesize(GRAVEL, (36, 40), preset="fast").image,
    "fill": lambda: synth.fill(GRAVEL, HOLE, preset="fast").image,
    "patches": lambda: morphed("patches"),
    "control": lambda: morphed("control"),
    "registration": lambda: morphed("registration"),
}
OTHERS: dict[str, Callable[[], Any]] = {
    "a guide": lambda: synth.synthesize(GRAVEL, guide=(GRAVEL, BRICK), preset="fast").image,
    "a video": lambda: synth.synthesize(CLIP, (7, 32, 36), preset="fast", stay=0.3).image,
    "variants": lambda: synth.synthesize(GRAVEL, (36, 40), preset="fast", rotate=(30,), mirror=True, tile=True).image,
    "tile": lambda: synth.tile(GRAVEL).image,
    "animate": lambda: animated(TENSOR),
    "animate a video": lambda: animated(torch.from_numpy(CLIP / 255).float().movedim(-1, 0)),
    "loop": lambda: [f.image for f in flow.loop(TENSOR, flow.vortices(2.0), (32, 36), frames=4)],
    "quilt": lambda: quilt(TENSOR, (48, 48), QuiltSettings(rotate=(30,), refine=5)).image,
    "textons": lambda: morphed("textons"),
}


@contextmanager
def doubles() -> Iterator[None]:
    torch.set_default_dtype(torch.float64)
    try:
        yield
    finally:
        torch.set_default_dtype(torch.float32)


@pytest.mark.parametrize("program", PROGRAMS | OTHERS)
def test_programs_where_numbers_are_doubles_unless_told(program: str) -> None:
    make = (PROGRAMS | OTHERS)[program]
    with doubles():
        made = make()
    for ours, usual in zip(made, make(), strict=True):
        assert ours.dtype == usual.dtype
        assert np.array_equal(ours, usual)


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("without", [torch.no_grad, torch.inference_mode])
def test_programs_where_derivatives_are_switched_off(program: str, without: Callable[[], Any]) -> None:
    with without():
        made = PROGRAMS[program]()
    assert np.array_equal(made, PROGRAMS[program]())


def test_features_of_what_inference_mode_has_made_are_transposed() -> None:
    with torch.inference_mode():
        metric = Metric((4, 4), torch.ones(1), (Feature(gradient),))
        transposed = metric.features_transposed(torch.ones(2, 24))
    assert torch.equal(
        transposed, Metric((4, 4), torch.ones(1), (Feature(gradient),)).features_transposed(torch.ones(2, 24))
    )


def test_pictures_of_flows_and_measures_where_numbers_are_doubles_unless_told() -> None:
    with doubles():
        drawn = flow.picture(flow.rotation(1.5)(0.0, (32, 36)), arrows=8)
    assert torch.equal(drawn, flow.picture(flow.rotation(1.5)(0.0, (32, 36)), arrows=8))
    assert drawn.dtype == torch.float32
