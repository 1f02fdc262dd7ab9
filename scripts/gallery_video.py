"""Video textures, after figure 26 of Kwatra's thesis, from clips of your own.

    python scripts/gallery_video.py clips              every video and folder of frames in a folder
    python scripts/gallery_video.py fire.mp4 --size 240x240 --frames 100

Problem: find the video x that minimizes the texture energy over windows in space and time,

    U_t(x) = sum_p |x_p - z_p|^r,    x_p: 16 x 16 pixels over 4 frames, z_p: the window of the clip nearest to it,

at three resolutions of which none is coarser in time (section 5.5). Without clips, rain made here is used. Each clip
gives a picture: above the clip, below what was made of it, some frames of each and then a row and a column of pixels
over time, where motion can be compared; and the video itself.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import tables
import torch
from bench_video import RATE, Task, by_engine, given_clips
from torch import Tensor

from synth import write_image
from synth.io.videos import write_video
from synth.sheets import stacked, video_sheet

DENSITY, SPEED = 1 / 5000, 1.1
"""Drops per pixel and frame; pixels by which a ring grows in a frame."""


def figure_26(clip: Tensor, made: Tensor) -> Tensor:
    """A clip and the video texture made of it: frames, and slices through time."""
    return stacked([video_sheet(clip), video_sheet(made)])


def rain(frames: int, side: int, seed: int = 0) -> Tensor:
    """Drops that fall on water, and their rings: a clip (3, frames, side, side) in [0, 1]."""
    rng = np.random.default_rng(seed)
    early, around = 30, 20  # frames and pixels from which rings still come
    count = round(DENSITY * (frames + early) * (side + 2 * around) ** 2)
    when, *where = (rng.uniform(-low, high, count)[:, None, None] for low, high in
                    ((early, frames), (around, side + around), (around, side + around)))  # fmt: skip
    down, across = np.mgrid[:side, :side].astype(float)
    clip = []
    for t in range(frames):
        age = np.clip(t - when, 0, early)
        ring = np.hypot(down - where[0], across - where[1]) - SPEED * age
        height = (np.exp(-((ring / 3) ** 2) - age / 9) * np.cos(1.6 * ring) * ((t > when) & (age < early))).sum(0)
        light = np.gradient(height, axis=0) + 0.6 * np.gradient(height, axis=1)
        clip.append([0.22 + 0.35 * light + 0.05 * height, 0.36 + 0.38 * light, 0.44 + 0.4 * light])
    return torch.from_numpy(np.array(clip)).float().movedim(0, 1).clamp(0, 1)


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("clips", nargs="*", type=Path, help="videos, folders of frames, or folders of either")
    parser.add_argument("--size", type=tables.size, help="of the videos, WIDTHxHEIGHT (the clip's)")
    parser.add_argument("--frames", type=int, help="of the videos (twice the clip's)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/gallery_video"), help="folder for the pictures")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    clips = given_clips(arguments.clips) if arguments.clips else {"rain": rain(40, 72)}
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name, clip in clips.items():
        size = arguments.size or tuple(clip.shape[2:])
        made = by_engine(Task(clip, (arguments.frames or 2 * clip.shape[1], *size), arguments.seed)).clamp(0, 1)
        path = arguments.out / f"figure_26_{name}.png"
        write_image(path, figure_26(clip, made), tables.eight_bit(clip[:, 0]), overwrite=True)
        write_video(path.with_suffix(".mp4"), made, RATE, overwrite=True)
        print(f"{path}: {figure_26.__doc__}", flush=True)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("gallery_video", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
