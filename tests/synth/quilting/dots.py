"""What the tests of quilting share: textures, and what a result says it copied."""

import numpy as np
import torch


def texture(*shape: int, seed: int = 0) -> torch.Tensor:
    """Smooth noise with a few bright dots, (C, *shape)."""
    generator = torch.Generator().manual_seed(seed)
    rough = torch.rand(*shape, generator=generator)
    for axis in range(1, len(shape)):
        rough = (rough + rough.roll(1, axis) + rough.roll(-1, axis)) / 3
    return rough + 0.2 * (torch.rand(*shape, generator=generator) > 0.97)


def copied(result, exemplar: torch.Tensor) -> torch.Tensor:
    """The output as its offsets say it was copied; one source only."""
    place = result.offset.numpy() + np.indices(result.patch.shape)
    return exemplar[(slice(None), *[torch.from_numpy(p) for p in place])]
