"""What the tests of the command line share: an exemplar."""

import torch

from synth import Kind

RGB = Kind("uint8", ("R", "G", "B"))
QUICK = ["--preset", "fast", "--size", "64x48"]


def texture(channels: int = 3, size: tuple[int, int] = (64, 64), seed: int = 0) -> torch.Tensor:
    """Stripes with noise: (C, H, W) in [0, 1]."""
    generator = torch.Generator().manual_seed(seed)
    wave = torch.sin(torch.arange(size[1]) * 0.8) * 0.3 + 0.5
    return (wave + 0.1 * torch.randn(channels, *size, generator=generator)).clamp(0, 1)
