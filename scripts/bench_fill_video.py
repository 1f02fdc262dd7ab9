"""Holes in videos: how like what was there is what fills them.

    python scripts/bench_fill_video.py clips                every video and folder of frames in a folder
    python scripts/bench_fill_video.py fire.mp4 --radius 0.1 --preset best --json figures.json

Without clips, waves made in code are used. The hole is a disc, at the same place in all frames. cpu is in seconds of
all threads; the others compare what fills the hole with what was there:

    sharpness   mean absolute step from pixel to pixel, 1 is right, below is blur
    change      mean absolute step from frame to frame, 1 is right, 0 stands still
    border      mean absolute step across the hole's border, 1 is right, above a seam is seen
    off         rms difference, in standard deviations of what was there: 1.4 is that of another texture as this

Each result goes to a folder of its own, and beside it a picture: some frames, the middle row of pixels over time and
the middle column.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import tables
import torch
from bench_video import RATE, given_clips, in_8_bits, write_sheet
from gallery_quilting import waves
from torch import Tensor

from kwatra import InputError
from synth import fill
from synth.io.videos import write_video

FIGURES = ("cpu", "sharpness", "change", "border", "off")


def disc(clip: Tensor, share: float) -> Tensor:
    """A disc (H, W) about a clip's middle (C, T, H, W), its radius a share of the shorter side."""
    height, width = clip.shape[2:]
    down, across = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    away = torch.hypot(down - (height - 1) / 2, across - (width - 1) / 2)
    return away < share * min(height, width)


def figures(made: Tensor, truth: Tensor, hole: Tensor) -> dict[str, float]:
    """What fills a hole (H, W) of all frames of a video (C, T, H, W), beside what was there."""

    def inside(video: Tensor) -> float:
        return sum(float(step(video, axis)[..., both(hole, axis)].mean()) for axis in (0, 1))

    def across(video: Tensor) -> float:
        return sum(float(step(video, axis)[..., hole.diff(dim=axis)].mean()) for axis in (0, 1))

    def change(video: Tensor) -> float:
        return float(video[..., hole].diff(dim=1).abs().mean())

    there = truth[..., hole]
    off = (made[..., hole] - there).square().mean().sqrt() / there.std()
    ratios = {"sharpness": inside, "change": change, "border": across}
    return {name: of(made) / of(truth) for name, of in ratios.items()} | {"off": float(off)}


def step(video: Tensor, axis: int) -> Tensor:
    """The absolute step of gray (T, ...) along rows or columns of a video (C, T, H, W)."""
    return video.mean(0).diff(dim=axis + 1).abs()


def both(hole: Tensor, axis: int) -> Tensor:
    """Where a pixel and the next along an axis are in the hole."""
    size = hole.shape[axis] - 1
    return hole.narrow(axis, 0, size) & hole.narrow(axis, 1, size)


def bench(clips: dict[str, Tensor], arguments: argparse.Namespace) -> Iterator[tables.Row]:
    """Fill a hole in every clip; videos and their pictures go to `arguments.out`."""
    for name, clip in clips.items():
        tables.progress(name)
        hole = disc(clip, arguments.radius)
        if not bool(hole.any()) or clip.shape[1] < 2:
            raise InputError(
                f"{name} has {clip.shape[1]} frames of {clip.shape[3]}x{clip.shape[2]}, too few for a hole"
            )
        cpu = time.process_time()
        made = in_8_bits(fill(clip, hole, preset=arguments.preset, seed=arguments.seed).image)
        cpu = time.process_time() - cpu
        folder = arguments.out / name
        write_video(folder, made, RATE, tables.eight_bit(clip[:, 0]), overwrite=True)
        write_sheet(folder.with_name(f"{name}.png"), made)
        yield tables.Row(name, arguments.preset, name, {"cpu": cpu, **figures(made, clip, hole)})


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("clips", nargs="*", type=Path, help="videos, folders of frames, or folders of either")
    parser.add_argument("--radius", type=float, default=0.2, help="of the hole, as a share of the shorter side (0.2)")
    parser.add_argument("--preset", choices=("fast", "default", "best"), default="default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/bench_fill_video"), help="(out/bench_fill_video)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    clips = given_clips(arguments.clips) if arguments.clips else {"waves": waves(24, 48)}
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = tables.print_table(bench(clips, arguments), FIGURES, max(map(len, clips)))
    tables.write_json(rows, arguments.json)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_fill_video", lambda: run(arguments))


if __name__ == "__main__":
    torch.set_num_threads(1)  # cpu seconds then mean the same on every machine
    sys.exit(main())
