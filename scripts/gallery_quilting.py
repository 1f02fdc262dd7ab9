"""Graph-cut quilting, after figures 4, 8 to 12, 15 and 16 of Kwatra's thesis, with exemplars that anyone may publish.

Problem: sew a larger texture from patches of a small one so that no seam shows. Each patch is cut where it and what
lies beneath agree, by the labeling that minimizes the sum over neighbors s, t of

    M(s, t, A, B) = |A(s) - B(s)| + |A(t) - B(t)|.

The exemplars are scikit-image's brick, grass, gravel and deep field, and stones, cloth and
waves made here.
"""

import argparse
import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from exemplars import pebbles
from skimage import data, transform
from torch import Tensor

from synth import Kind, write_image
from synth.io.videos import write_video
from synth.quilting import (
    Overlay,
    QuiltSettings,
    default_settings,
    merge,
    quilt,
    quilt_video,
    seams_drawn,
)

RGB = Kind("uint8", ("R", "G", "B"))


def picture(array: np.ndarray, side: int) -> Tensor:
    """The top left square of an image, half as large, in RGB: (3, side, side)."""
    color = np.atleast_3d(array)[: 2 * side, : 2 * side]
    small = transform.resize(color / 255.0, (side, side), anti_aliasing=True)
    return torch.from_numpy(small).float().permute(2, 0, 1).expand(3, -1, -1).clamp(0, 1).contiguous()


def weave(side: int) -> Tensor:
    """Cloth of two threads over and under each other with a little unevenness, (3, side, side)."""
    generator = torch.Generator().manual_seed(0)
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    over = ((y // 6 + x // 6) % 2).bool()
    across = torch.where(over, y % 6, x % 6) - 2.5
    light = 1 - (across / 4) ** 2 + 0.05 * torch.randn(side, side, generator=generator)
    warm, cold = torch.tensor([0.8, 0.65, 0.4]), torch.tensor([0.25, 0.35, 0.5])
    return (torch.where(over, warm[:, None, None], cold[:, None, None]) * light).clamp(0, 1)


def waves(frames: int, side: int) -> Tensor:
    """A video of water-like waves, (3, frames, side, side): sines that travel in many directions."""
    generator = torch.Generator().manual_seed(0)
    t, y, x = torch.meshgrid(torch.arange(frames), torch.arange(side), torch.arange(side), indexing="ij")
    height = torch.zeros(frames, side, side)
    for _ in range(24):
        angle, phase = torch.rand(2, generator=generator) * 2 * math.pi
        length = 8 + 24 * torch.rand(1, generator=generator)
        along = x * angle.cos() + y * angle.sin()
        height += length / 32 * torch.sin(2 * math.pi * (along / length - t * length.rsqrt() / 4) + phase)
    level = (height / 8 + 0.5).clamp(0, 1)
    return torch.stack([0.15 + 0.5 * level**3, 0.3 + 0.55 * level**2, 0.45 + 0.5 * level])


def beside(*images: Tensor, gap: int = 8) -> Tensor:
    """Images (3, H, W) in a row on white."""
    height = max(image.shape[1] for image in images)
    row = []
    for image in images:
        page = torch.ones(3, height, image.shape[2] + gap)
        page[:, : image.shape[1], : image.shape[2]] = image
        row.append(page)
    return torch.cat(row, 2)[..., :-gap]


def figure_4(side: int) -> Tensor:
    """The texture before, while and after its seams are refined, the seams drawn below."""
    exemplar = pebbles(side)
    stages = [quilt(exemplar, (2 * side, 2 * side), QuiltSettings(refine=steps)) for steps in (0, 10, 60)]
    return torch.cat([beside(*[s.image for s in stages]), beside(*[seams_drawn(s) for s in stages])], 1)


def figure_8(side: int) -> Tensor:
    """Structured textures by matching whole patches, stochastic ones by sub-patches."""
    rows = []
    exemplars = ((picture(data.brick(), side), "whole"), (weave(side), "whole"), (picture(data.gravel(), side), "sub"))
    for exemplar, placement in exemplars:
        rows.append(beside(exemplar, quilt(exemplar, (2 * side, 2 * side), QuiltSettings(placement=placement)).image))
    return beside(*rows)


def figure_9(side: int) -> Tensor:
    """Natural images: grass, and a sky full of galaxies."""
    pictures = [picture(data.grass(), side), picture(data.hubble_deep_field()[200:], side)]
    settings = QuiltSettings(placement="sub")
    return beside(*[beside(p, quilt(p, (2 * side, 2 * side), settings).image) for p in pictures])


def figure_10(side: int) -> Tensor:
    """More variety from turned and mirrored variants: without and with."""
    exemplar = picture(data.gravel(), side)
    ways = (QuiltSettings(), QuiltSettings(rotate=(90, 180, 270), mirror=True))
    return beside(exemplar, *[quilt(exemplar, (2 * side, 2 * side), way).image for way in ways])


def figure_11(side: int) -> Tensor:
    """Perspective: one scale, and scales that grow from top to bottom."""
    exemplar = pebbles(side)
    ways = (QuiltSettings(), QuiltSettings(scale=(0.35, 0.455, 0.592, 0.769, 1.0), perspective=True))
    return beside(exemplar, *[quilt(exemplar, (2 * side, 2 * side), way).image for way in ways])


def figure_12(side: int) -> Tensor:
    """Two images merged: a patch of gravel laid into grass, and its seam."""
    grass, gravel = picture(data.grass(), 2 * side), picture(data.gravel(), side)
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    keep = (x - side / 2) ** 2 / 2 + (y - side / 2) ** 2 < (side / 5) ** 2
    result = merge(grass, [Overlay(gravel, (side // 2, side // 2), keep)])
    return beside(gravel, result.image, seams_drawn(result))


def figure_15(side: int) -> Tensor:
    """The seam of a loop: the window's frames in a row, red where the clip passes to its beginning."""
    result = quilt_video(waves(24, side), mode="transition", loop=True)
    frames = seams_drawn(result)[:, -8:]
    return beside(*frames.unbind(1))


def figure_16(side: int) -> dict[str, Tensor]:
    """Videos: a loop, twice the length by offsets in time, and by offsets in space and time."""
    clip = waves(24, side)

    def longer(mode: str) -> Tensor:
        return quilt_video(clip, mode=mode, settings=dataclasses.replace(default_settings(mode), refine=15)).image

    loop = quilt_video(clip, 48, mode="transition").image
    return {"loop": loop, "time": longer("time"), "spacetime": longer("spacetime")}


FIGURES: tuple[Callable[[int], Tensor], ...] = (
    figure_4,
    figure_8,
    figure_9,
    figure_10,
    figure_11,
    figure_12,
    figure_15,
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=96, help="side of the exemplars in pixels; outputs have twice that")
    parser.add_argument("--out", type=Path, default=Path("out/gallery_quilting"), help="folder for the pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for figure in FIGURES:
        path = arguments.out / f"{figure.__name__}.png"
        write_image(path, figure(arguments.side).clamp(0, 1), RGB, overwrite=True)
        print(f"{path}: {figure.__doc__}")
    for name, video in figure_16(min(arguments.side, 48)).items():
        path = arguments.out / f"figure_16_{name}.gif"
        write_video(path, video, 15, overwrite=True)
        print(f"{path}: {name}")


if __name__ == "__main__":
    main()
