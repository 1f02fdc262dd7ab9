"""Pairs of textures of which the halfway point is known."""

import numpy as np
import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from flow.warps import pixel_coordinates, warp


def disc(size: int, x: float, y: float, radius: float) -> Tensor:
    """A light disc on dark ground, (1, size, size), its border 1 px soft."""
    across, down = pixel_coordinates((size, size))
    distance = torch.hypot(across - x, down - y) - radius
    return 0.1 + 0.7 * torch.sigmoid(-2 * distance)[None]


def cloud(size: int, dx: float, part: float) -> Tensor:
    """Blobs (3, size, size), moved by dx px to the left, a part of the way from bluish to reddish."""
    noise = gaussian_filter(np.random.default_rng(0).standard_normal((size + 16, size + 16)), 3)
    gray = torch.from_numpy((noise - noise.min()) / (noise.max() - noise.min())).float()
    moved = warp(gray[None], pixel_coordinates((size, size)) + 8 + torch.tensor([dx, 0.0]).view(2, 1, 1))[0]
    return torch.stack([
        moved * (0.6 + 0.3 * part) + 0.05,
        moved * (0.8 - 0.3 * part) + 0.1 * part + 0.05,
        0.5 * moved + 0.2 * part,
    ])  # fmt: skip


def spots(size: int, seed: int, tone: float) -> Tensor:
    """Round spots at random, (3, size, size)."""
    generator = np.random.default_rng(seed)
    picture = torch.full((size, size), 0.2)
    for x, y in generator.uniform(0, size, (size // 2, 2)):
        picture = torch.maximum(picture, disc(size, x, y, 4.0)[0])
    return torch.stack([picture, tone * picture, (1 - tone) * picture])
