"""Discs of one size, each of its own color, on dark ground: elements whose truth is known."""

import numpy as np
import torch
from torch import Tensor

RADIUS = 9


def discs(rows: int, columns: int, seed: int = 0, noise: float = 0.0) -> tuple[Tensor, np.ndarray]:
    """An image (3, 26 rows, 26 columns), and the number of the disc each pixel is of, from 1; 0 on the ground."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[: 26 * rows, : 26 * columns]
    image, number = np.full((3, *y.shape), 0.1), np.zeros(y.shape, int)
    for row in range(rows):
        for column in range(columns):
            cy, cx = 26 * np.array([row, column]) + 13 + random.integers(-2, 3, 2)
            inside = (y - cy) ** 2 + (x - cx) ** 2 <= RADIUS**2
            number[inside] = row * columns + column + 1
            image[:, inside] = random.uniform(0.4, 1.0, (3, 1))
    image += noise * random.standard_normal(image.shape)
    return torch.from_numpy(image.clip(0, 1)).float(), number
