"""Video textures, after figure 26 of Kwatra's thesis, from clips of your own.

    python scripts/gallery_video.py clips              every video and folder of frames in a folder
    python scripts/gallery_video.py fire.mp4 --size 240x240 --frames 100

Problem: find the video x that minimizes the texture energy over windows in space and time,

    U_t(x) = sum_p |x_p - z_p|^r,    x_p: 16 x 16 pixels over 4 frames, z_p: the window of the clip nearest to it,

at three resolutions of which none is coarser in time (section 5.5). Without clips, waves made here are used. Each clip
gives a picture: above the clip, below what was made of it, some frames of each and then a row and a column of pixels
over time, where motion can be compared; and the video itself.
"""

import argparse
import sys
from pathlib import Path

import tables
from bench_video import RATE, Task, by_engine, given_clips
from gallery_quilting import waves
from torch import Tensor

from synth import write_image
from synth.io.videos import write_video
from synth.sheets import stacked, video_sheet


def figure_26(clip: Tensor, made: Tensor) -> Tensor:
    """A clip and the video texture made of it: frames, and slices through time."""
    return stacked([video_sheet(clip), video_sheet(made)])


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
    clips = given_clips(arguments.clips) if arguments.clips else {"waves": waves(24, 48)}
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
