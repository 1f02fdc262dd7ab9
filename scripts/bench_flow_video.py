#!/usr/bin/env python3
"""Videos that flow: do they move as told, and do they live as their exemplar does?

    python scripts/bench_flow_video.py smoke.mp4 fountain/                 two clips, three fields
    python scripts/bench_flow_video.py river.mp4 --fields sink wind.flo --frames 100 --methods kwatra still

Without clips, waves made in code are used. The methods: kwatra (flow.animate); still, one frame of the clip animated;
published, equation 29 over the whole volume (flow.published; it is slow, so --short frames at most); exact, a frame of
the clip that is moved by the field and nothing else: what the measures make of the motion alone; and truth, each
frame of the clip and the next one, its own mean motion undone and moved by the field: what they make of motion and life
together, in the middle of the frame; and panned, the clip, mirrored beyond its borders, seen through a window that
moves against a uniform field: footage that flows as told on top of its own motion. That is what overall makes of any
flow, since it compares motion with a clip's that has none of it, and what becomes of a scene that is bright on one
side: its light changes as it flows. Only sharp and overall are read of it; the others would count its own motion as an
error. The figures of others are to be read beside these. The columns:

    epe        mean end-point error, px: how far the motion that optical flow sees is from the field
    epe mean   the same of the motions' mean over time, in which what the texture does about it cancels
    life       change of a frame about the one before, moved by the field, in units of the clip's about its own mean
               motion: 1 is right, 0 a still that is carried
    agitation  mean length of what the motion does about its mean and the field, in the clip's: 1 is right
    sharp      mean absolute gradient, in the clip's
    overall    of kwatra.measure for videos (lower is better)
    s/frame    cpu seconds a frame
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import tables
import torch
from bench_video import given_clips, in_8_bits, write_sheet
from gallery_quilting import waves
from torch import Tensor

import flow
from flow.warps import BORDER, pixel_coordinates
from kwatra import InputError, measure
from synth import field_of

FIELDS = ("uniform", "rotation", "vortices")
NAMES = ["epe", "epe mean", "life", "agitation", "sharp", "overall", "s/frame"]
MOTION = NAMES[:4]


Steps = tuple[Tensor, Tensor]
"""Frames (C, N, H, W), and what each becomes."""


@dataclass(frozen=True)
class Task:
    """A clip (C, T, H, W) that is to flow along a field, in so many frames of a size."""

    clip: Tensor
    field: flow.Field
    shape: tuple[int, int]
    frames: int
    short: int


def by_kwatra(task: Task) -> Tensor:
    return stacked(flow.animate(task.clip, task.field, task.shape, frames=task.frames))


def by_still(task: Task) -> Tensor:
    return stacked(flow.animate(task.clip[:, 0], task.field, task.shape, frames=task.frames))


def by_volume(task: Task) -> Tensor:
    return stacked(flow.published(task.clip, task.field, task.shape, min(task.frames, task.short)))


def exactly(task: Task) -> Tensor:
    """A frame, repeated to the size, as it is where the field has brought its pixels from."""
    still = task.clip[:, 0]
    for axis, side in enumerate(task.shape, 1):
        still = still.index_select(axis, torch.arange(side) % still.shape[axis])
    places, frames = pixel_coordinates(task.shape), []
    for number in range(min(task.frames, task.short)):
        frames.append(flow.warp(still, places, "lanczos"))
        places = flow.warp(places, flow.lookup(task.field(number, task.shape)).coordinates, "bilinear")
    return torch.stack(frames, 1)


def truly(task: Task) -> Steps:
    """Each frame of the clip, and the next one as it would be, moved by the field instead of as on the mean."""
    own = motions(steps(task.clip)).mean(0)
    if own.shape[1:] != task.shape:
        raise InputError("the truth is known at the clip's own size alone; leave out --size, or truth")
    before, after = steps(task.clip[:, : task.frames])
    moved = []
    for number, shown in enumerate(after.unbind(1)):
        back = flow.lookup(task.field(number, task.shape)).coordinates
        moved.append(flow.warp(shown, back + flow.warp(own, back, "bilinear"), "lanczos"))
    return middle(before), middle(in_8_bits(torch.stack(moved, 1)))


def panned(task: Task) -> Tensor:
    """The clip's own frames, mirrored beyond their borders, through a window that moves against the field."""
    flows = task.field(0, task.shape)
    step = flows[:, 0, 0].view(2, 1, 1)
    if not task.field.steady or bool((flows - step).abs().max() > 1e-3):
        raise InputError("a window moves in one direction: only uniform fields are panned; leave out others, or panned")
    sides = torch.tensor(task.clip.shape[:1:-1]).view(2, 1, 1)
    shown = []
    for number, frame in enumerate(task.clip[:, : task.frames].unbind(1)):
        places = (pixel_coordinates(task.shape) - number * step + 0.5) % (2 * sides)
        shown.append(flow.warp(frame, places.minimum(2 * sides - places) - 0.5, "lanczos"))
    return torch.stack(shown, 1)


def middle(values: Tensor) -> Tensor:
    """The middle half of both sides of (..., H, W)."""
    height, width = values.shape[-2:]
    return values[..., height // 4 : height - height // 4, width // 4 : width - width // 4]


METHODS: dict[str, Callable[[Task], Tensor | Steps]] = {
    "kwatra": by_kwatra,
    "still": by_still,
    "published": by_volume,
    "exact": exactly,
    "truth": truly,
    "panned": panned,
}


def stacked(frames: Iterator[flow.Frame]) -> Tensor:
    return torch.stack([frame.image for frame in frames], 1)


def steps(video: Tensor) -> Steps:
    """The frames of a video but the last, and those after them."""
    return video[:, :-1], video[:, 1:]


def pairs(made: Steps) -> Iterator[tuple[Tensor, Tensor]]:
    return zip(made[0].unbind(1), made[1].unbind(1), strict=True)


def motions(made: Steps) -> Tensor:
    """The motion that is seen from each frame to the next, (N, 2, H, W)."""
    return torch.stack([flow.seen(one, other) for one, other in pairs(made)])


def inner(values: Tensor) -> Tensor:
    """Values (..., H, W) but for the borders, where half of what is to be seen is missing."""
    border = min(BORDER, min(values.shape[-2:]) // 4)
    return values[..., border:-border, border:-border]


def change(made: Steps, along: Tensor) -> float:
    """Mean change of what frames become about them, moved along flows (N, 2, H, W)."""
    both = zip(pairs(made), along, strict=True)
    left = [inner(after - flow.warp(before, flow.lookup(f).coordinates)).abs().mean() for (before, after), f in both]
    return float(torch.stack(left).mean())


def gradient(video: Tensor) -> float:
    return float(video.diff(dim=2).abs().mean() + video.diff(dim=3).abs().mean())


def figures_of(made: Tensor | Steps, task: Task) -> dict[str, float]:
    """All columns but the time, of a video (C, T, H, W); of steps that are no video all but overall."""
    overall = measure(made, task.clip)["overall"] if isinstance(made, Tensor) else math.nan
    shape = tuple(made.shape[2:]) if isinstance(made, Tensor) else task.shape
    made = steps(made) if isinstance(made, Tensor) else made
    wanted = torch.stack([task.field(number, shape) for number in range(made[0].shape[1])])
    clip, own = task.clip, motions(steps(task.clip))
    if wanted.shape[2:] != made[0].shape[2:]:
        wanted, clip, own = middle(wanted), middle(clip), middle(own)
    off = inner(motions(made) - wanted)
    drift = own.mean(0, keepdim=True)
    agitated = inner(own - drift).norm(dim=1).mean()
    return {
        "epe": float(off.norm(dim=1).mean()),
        "epe mean": float(off.mean(0).norm(dim=0).mean()),
        "life": change(made, wanted) / max(change(steps(clip), drift.expand_as(own)), 1e-9),
        "agitation": float((off - off.mean(0)).norm(dim=1).mean() / agitated.clamp(min=1e-9)),
        "sharp": gradient(made[1]) / max(gradient(clip), 1e-9),
        "overall": overall,
    }


def bench(clips: dict[str, Tensor], arguments: argparse.Namespace) -> Iterator[tables.Row]:
    for clip_name, clip in clips.items():
        for name in arguments.fields:
            field, shape = field_of(name, resample=True), arguments.size or tuple(clip.shape[2:])
            task = Task(clip, field, shape, arguments.frames, arguments.short)
            for method in arguments.methods:
                title = f"{clip_name} {Path(name).stem}"
                tables.progress(f"{title}: {method}")
                cpu = time.process_time()
                try:
                    made = METHODS[method](task)
                    made = in_8_bits(made) if isinstance(made, Tensor) else made
                except InputError as error:
                    print(f"{title}  {method} is left out: {error}", flush=True)
                    continue
                shown = made if isinstance(made, Tensor) else made[1]
                cpu = (time.process_time() - cpu) / shown.shape[1]
                file = f"{title.replace(' ', '_').replace(':', '-')}_{method}.png"
                write_sheet(arguments.out / file, shown)
                figures = figures_of(made, task)
                if method == "panned":
                    figures |= dict.fromkeys(MOTION, math.nan)
                yield tables.Row(title, method, file, {**figures, "s/frame": cpu})


def parsed(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", nargs="*", type=Path, help="videos, folders of frames, or folders of such")
    parser.add_argument("--fields", nargs="+", default=FIELDS, help=f"names or files ({' '.join(FIELDS)})")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="METHOD")
    parser.add_argument("--size", type=tables.size, help="of the frames, WIDTHxHEIGHT (the clip's)")
    parser.add_argument("--frames", type=int, default=60, help="how many (60)")
    parser.add_argument("--short", type=int, default=16, help="at most so many of published and exact (16)")
    parser.add_argument("--out", type=Path, default=Path("out/bench_flow_video"), help="folder for pictures")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    arguments.out.mkdir(parents=True, exist_ok=True)
    clips = given_clips(arguments.clips) or {"waves": waves(24, 96)}
    width = max(map(len, clips)) + 1 + max(len(Path(name).stem) for name in arguments.fields)
    tables.print_table(bench(clips, arguments), NAMES, width)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_flow_video", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
