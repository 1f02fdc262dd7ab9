"""What the tests of image files share: arrays of every kind."""

import numpy as np
import torch

GRAY, GRAY_ALPHA, RGB, RGBA = ("Y",), ("Y", "A"), ("R", "G", "B"), ("R", "G", "B", "A")
SHAPE = (11, 14)


def some_array(dtype: str, channels: int, seed: int = 0) -> np.ndarray:
    generator = np.random.default_rng(seed)
    shape = (*SHAPE, channels)
    if dtype == "bool":
        return generator.random(shape) > 0.5
    if dtype.startswith("u"):
        return generator.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    return (generator.standard_normal(shape) * 3).astype(np.float32).astype(dtype)


def as_pixels(array: np.ndarray) -> torch.Tensor:
    scale = np.iinfo(array.dtype).max if array.dtype.kind == "u" else 1
    return torch.from_numpy(array.transpose(2, 0, 1).astype(np.float32) / np.float32(scale))
