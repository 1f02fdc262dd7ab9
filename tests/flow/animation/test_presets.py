"""What the presets of renewal spend is counted in values that tensor operations make, whatever the machine."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from skimage import data
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

import flow
from flow.animation.settings import seldom
from kwatra import Exemplar, Settings


class Work(TorchDispatchMode):
    values = 0

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):  # type: ignore[no-untyped-def]
        out = func(*args, **(kwargs or {}))
        if isinstance(out, torch.Tensor):
            self.values += out.numel()
        return out


def gravel() -> Tensor:
    return torch.from_numpy(data.gravel()[:96, :96].astype(np.float32) / 255)[None]


def clip() -> Tensor:
    """Smooth noise, in time as well: (1, 8, 48, 48)."""
    noise = torch.rand(1, 10, 52, 52, generator=torch.Generator().manual_seed(0))
    smooth = F.avg_pool3d(noise, (3, 5, 5), 1)
    return (smooth - smooth.amin()) / (smooth.amax() - smooth.amin())


@pytest.mark.parametrize(("presets", "texture"), [(flow.PRESETS, gravel), (flow.VIDEO_PRESETS, clip)])
def test_the_presets_spend_rising_work_on_a_frame(
    presets: dict[str, flow.Renewing], texture: Callable[[], Tensor]
) -> None:
    work = []
    for preset in presets.values():
        start = Settings(seams=1, iterations=1)
        exemplar = Exemplar.of(texture())
        turn = None if exemplar.canvas.ndim > 3 else False
        field = flow.rotation(12.0)
        frames = flow.animate(exemplar, field, (128, 128), frames=2, renewing=preset, synthesis=start, turn=turn)
        next(frames)
        with Work() as counted:
            list(frames)
        work.append(counted.values)
    assert list(presets) == ["fast", "default", "best"]
    assert all(b > 1.05 * a for a, b in pairwise(work))


def test_the_default_preset_is_what_is_done_without_one() -> None:
    assert flow.PRESETS["default"] == flow.Renewing()


@pytest.mark.parametrize("preset", flow.PRESETS)
def test_less_is_renewed_of_elements_that_are_drawn_whole(preset: str) -> None:
    usual = flow.PRESETS[preset]
    rare = seldom(usual)
    assert rare.tolerance > usual.tolerance
    assert rare.blocks <= usual.blocks
    assert seldom(rare) == rare
