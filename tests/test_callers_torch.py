"""What a caller has set of torch is the caller's: results are the same bits, whether derivatives are taken or not."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import torch
from skimage import data

import synth
from kwatra import Feature, gradient
from kwatra.windows.metric import Metric

GRAVEL, BRICK = data.gravel()[:32, :36], data.brick()[:32, :36]
HOLE = np.zeros(GRAVEL.shape, bool)
HOLE[10:18, 12:22] = True


def morphed(method: str) -> Sequence[np.ndarray]:
    return synth.morph(GRAVEL, BRICK, 3, method=method, preset="fast").frames


PROGRAMS: dict[str, Callable[[], Any]] = {
    "synthesize": lambda: synth.synthesize(GRAVEL, (36, 40), preset="fast").image,
    "fill": lambda: synth.fill(GRAVEL, HOLE, preset="fast").image,
    "patches": lambda: morphed("patches"),
    "control": lambda: morphed("control"),
    "registration": lambda: morphed("registration"),
}


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
