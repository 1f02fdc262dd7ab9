"""What the presets of renewal spend is counted in values that tensor operations make, whatever the machine."""

from itertools import pairwise

import numpy as np
import torch
from skimage import data
from torch.utils._python_dispatch import TorchDispatchMode

import flow
from kwatra import Exemplar, Settings


class Work(TorchDispatchMode):
    values = 0

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):  # type: ignore[no-untyped-def]
        out = func(*args, **(kwargs or {}))
        if isinstance(out, torch.Tensor):
            self.values += out.numel()
        return out


def test_the_presets_spend_rising_work_on_a_frame() -> None:
    exemplar = Exemplar.of(torch.from_numpy(data.gravel()[:96, :96].astype(np.float32) / 255)[None])
    work = []
    for preset in flow.PRESETS.values():
        start = Settings(seams=1, iterations=1)
        frames = flow.animate(exemplar, flow.rotation(12.0), (128, 128), frames=2, renewing=preset, synthesis=start)
        next(frames)
        with Work() as counted:
            list(frames)
        work.append(counted.values)
    assert list(flow.PRESETS) == ["fast", "default", "best"]
    assert all(b > 1.2 * a for a, b in pairwise(work))
    assert flow.PRESETS["default"] == flow.Renewing()
