"""Video textures: quality and cost beside other ways to make a video from a clip.

    python scripts/bench_video.py clips                      every video and folder of frames in a folder
    python scripts/bench_video.py fire.mp4 --size 240x240 --frames 100
    python scripts/bench_video.py clips --methods kwatra quilting --json figures.json

Without clips, waves made in code are used. The methods: kwatra (the engine); published, the engine as in section 5.5 of
the thesis (random windows to begin with, their mean, colors carried from level to level); quilting, by offsets in space
and time; loop, the clip played again and again; and linear, a linear dynamic system (Doretto et al. 2003), which only
makes the clip's own size. Unseen compares the first half of the clip with the second: what another shot of the same
would score, the mark to read the others by.

cpu is in seconds of all threads; the columns after it are those of kwatra.measure for videos (`kwatra score --help`
says what they mean), the last the one to rank by: lower is better, but read it with `replay`. Frames are judged in 8
bits. Each method's frames go to a folder of their own, and beside it a picture: some frames, the middle row of pixels
over time and the middle column.
"""

import argparse
import dataclasses
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import tables
import torch
import torch.nn.functional as F
from gallery_quilting import waves
from linear_system import linear_system
from torch import Tensor

from kwatra import Exemplar, InputError, Level, Settings, measure, optimize
from kwatra.scoring.video import FIGURES
from synth import synthesize, write_image
from synth.io.videos import is_video, read_video, write_video
from synth.quilting import default_settings, quilt_video
from synth.sheets import video_sheet

RATE = 25.0


@dataclass(frozen=True)
class Task:
    """What is asked for: a clip (C, T, H, W), the output's frames, height and width, seed, and the engine's preset."""

    clip: Tensor
    shape: tuple[int, int, int]
    seed: int
    preset: str = "default"


def by_engine(task: Task) -> Tensor:
    return synthesize(task.clip, task.shape, preset=task.preset, seed=task.seed).image


def as_published(task: Task) -> Tensor:
    """Three resolutions, none coarser in time, windows of 16 x 16 x 4 (as far as they fit)."""
    frames, height, width = task.shape
    exemplar, image = Exemplar.of(task.clip), None
    least = min(*task.clip.shape[2:], height, width)
    depth = min(4, frames, task.clip.shape[1])
    for factor in [factor for factor in (4, 2, 1) if factor == 1 or least >= 16 * factor]:
        there = (frames, -(-height // factor), -(-width // factor))
        level = Level(1, min(16, least // factor), depth=depth, route="approximate")
        start = "windows" if image is None else F.interpolate(image[None], there, mode="trilinear")[0]
        coarse = exemplar.coarser((1, factor, factor))
        settings = Settings(levels=(level,))
        image = optimize(coarse, there, settings=settings, seed=task.seed, start=start).image
    assert image is not None  # there is at least one level
    return image


def by_quilting(task: Task) -> Tensor:
    frames, *size = task.shape
    settings = dataclasses.replace(default_settings("spacetime"), seed=task.seed)
    return quilt_video(task.clip, frames, size, mode="spacetime", settings=settings).image


def looped(task: Task) -> Tensor:
    """The clip again and again, in space as well where that is larger."""
    video = task.clip
    for axis, length in enumerate(task.shape, 1):
        video = video.index_select(axis, torch.arange(length) % video.shape[axis])
    return video


def by_linear_system(task: Task) -> Tensor:
    if tuple(task.clip.shape[2:]) != task.shape[1:]:
        raise InputError("a linear dynamic system keeps its clip's size")
    if task.clip.shape[1] < 4:
        raise InputError(f"a linear dynamic system needs 4 frames, the clip has {task.clip.shape[1]}")
    return linear_system(task.clip, task.shape[0], task.seed)


METHODS: dict[str, Callable[[Task], Tensor]] = {
    "kwatra": by_engine,
    "published": as_published,
    "quilting": by_quilting,
    "loop": looped,
    "linear": by_linear_system,
}


def bench(clips: dict[str, Tensor], arguments: argparse.Namespace) -> Iterator[tables.Row]:
    """Run every method on every clip; videos and their pictures go to `arguments.out`."""
    for name, clip in clips.items():
        size = arguments.size or tuple(clip.shape[2:])
        task = Task(clip, (arguments.frames or 2 * clip.shape[1], *size), arguments.seed, arguments.preset)
        write_sheet(arguments.out / f"{name}.png", clip)
        half = clip.shape[1] // 2
        yield tables.Row(name, "unseen", "", {"cpu": 0.0, **measure(clip[:, :half], clip[:, -half:])})
        for method in arguments.methods:
            tables.progress(f"{name}: {method}")
            try:
                cpu = time.process_time()
                video = in_8_bits(METHODS[method](task))
                cpu = time.process_time() - cpu
            except InputError as error:
                print(f"{name}  {method} is left out: {error}", flush=True)
                continue
            folder = arguments.out / f"{name}_{method}"
            write_video(folder, video, RATE, tables.eight_bit(clip[:, 0]), overwrite=True)
            write_sheet(folder.with_name(f"{folder.name}.png"), video)
            yield tables.Row(name, method, folder.name, {"cpu": cpu, **measure(video, clip)})


def in_8_bits(video: Tensor) -> Tensor:
    return (video.clamp(0, 1) * 255).round() / 255


def write_sheet(path: Path, video: Tensor) -> None:
    write_image(path, video_sheet(video), tables.eight_bit(video[:, 0]), overwrite=True)


def given_clips(paths: list[Path]) -> dict[str, Tensor]:
    """Clips (C, T, H, W) by name: videos, folders of frames, and all that are in a folder of such."""
    found = [inside for path in paths for inside in clips_in(path) or [path]]
    return {path.stem: read_video(path).frames for path in found}


def clips_in(path: Path) -> list[Path]:
    if not path.is_dir():
        return []
    return sorted(inside for inside in path.iterdir() if is_video(inside))


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("clips", nargs="*", type=Path, help="videos, folders of frames, or folders of either")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="METHOD")
    parser.add_argument("--size", type=tables.size, help="of the outputs, WIDTHxHEIGHT (the clip's)")
    parser.add_argument("--frames", type=int, help="of the outputs (twice the clip's)")
    parser.add_argument("--preset", choices=("fast", "default", "best"), default="default", help="of kwatra")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/bench_video"), help="folder for videos (out/bench_video)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    clips = given_clips(arguments.clips) if arguments.clips else {"waves": waves(24, 48)}
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = tables.print_table(bench(clips, arguments), ("cpu", *FIGURES), max(map(len, clips)))
    tables.write_json(rows, arguments.json)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_video", lambda: run(arguments))


if __name__ == "__main__":
    torch.set_num_threads(1)  # cpu seconds then mean the same on every machine
    sys.exit(main())
