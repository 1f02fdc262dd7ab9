"""Flowing textures: motion, quality, flicker and cost, beside other ways to make a texture flow.

    python scripts/bench_flow.py                                     textures that come with scikit-image, five fields
    python scripts/bench_flow.py nuts.png --fields rotation wind.flo --frames 301 --at 100,300
    python scripts/bench_flow.py --methods kwatra warping --write out/flow

Rows are exemplar and field. The methods: kwatra (flow.animate); warping, which warps the colors of the frame before,
bicubic; carried, the still where the field has brought it, read from the still itself in each frame, so that nothing is
lost and nothing renewed: what the measures make of the motion alone; independent, a still from another seed each frame;
and thesis, algorithm 3 as published (flow.published). All begin with the same still. The columns:

    epe          mean end-point error, px: how far the motion that optical flow sees between frames is from the field
    epe still    the same between the still and one warp of it, by the sharpest interpolation: what the measure allows
    flicker      mean absolute difference between a frame and the warped one before it, in the exemplar's deviations
    flick still  the same between the still and one warp of it: what two interpolations differ by
    overall      the still's figure, of kwatra.measure (lower is better)
    moved        that of the still moved by half a pixel, as a multiple of the still's: what any motion costs
    overall@N    that of frame N, as a multiple of the still's
    sharp@N      the sharpness of frame N, as a multiple of the still's
    s/frame      wall seconds per frame after the first
    stills       cpu seconds per frame, in those of the still

Frames are judged in 8 bits, and motion 16 px and more from the border. Of carried and thesis only few frames are made
(--short); independent's few frames stand for those asked for, since all are alike.
"""

import argparse
import itertools
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path

import tables
from exemplars import brick, gravel, pebbles
from torch import Tensor

import flow
from flow.warps import BORDER, pixel_coordinates
from kwatra import Exemplar, measure, optimize
from kwatra.base import mean
from synth import field_of, write_flow, write_image

FIELDS = ("rotation", "sink", "source", "uniform", "noise")
SIDE = 160


@dataclass(frozen=True)
class Task:
    """A texture that is to flow: exemplar (C, H, W), the frames' size, how to renew, and the seed."""

    exemplar: Tensor
    field: flow.Field
    shape: tuple[int, int]
    preset: str
    seed: int


def kwatra_frames(task: Task) -> Iterator[Tensor]:
    renewing = flow.PRESETS[task.preset]
    frames = flow.animate(task.exemplar, task.field, task.shape, renewing=renewing, seed=task.seed)
    return (frame.image for frame in frames)


def warped_frames(task: Task) -> Iterator[Tensor]:
    frame = next(kwatra_frames(task))
    for look in lookups(task):
        yield frame
        frame = flow.filled(flow.warp(frame, look.coordinates), look.known)


def carried_frames(task: Task) -> Iterator[Tensor]:
    still, places = next(kwatra_frames(task)), pixel_coordinates(task.shape)
    for look in lookups(task):
        yield flow.warp(still, places, "lanczos")
        places = flow.warp(places, look.coordinates, "bilinear")


def lookups(task: Task) -> Iterator[flow.Lookup]:
    """Where the pixels of each frame come from in the one before; computed once if the field is steady."""
    look = flow.lookup(task.field(0, task.shape))
    for number in itertools.count(1):
        yield look
        if not task.field.steady:
            look = flow.lookup(task.field(number, task.shape))


def independent_frames(task: Task) -> Iterator[Tensor]:
    yield next(kwatra_frames(task))
    seed = task.seed
    while True:
        seed += 1
        yield optimize(Exemplar.of(task.exemplar), task.shape, seed=seed).image


def published_frames(task: Task) -> Iterator[Tensor]:
    frames = flow.published(Exemplar.of(task.exemplar), task.field, task.shape, sys.maxsize, seed=task.seed)
    return (frame.image for frame in frames)


@dataclass(frozen=True)
class Method:
    """How frames are made, whether only few of them, and whether any frame stands for any other."""

    frames: Callable[[Task], Iterator[Tensor]]
    few: bool = False
    alike: bool = False


METHODS = {
    "kwatra": Method(kwatra_frames),
    "warping": Method(warped_frames),
    "carried": Method(carried_frames, few=True),
    "independent": Method(independent_frames, few=True, alike=True),
    "thesis": Method(published_frames, few=True),
}


def figure_names(at: Iterable[int]) -> list[str]:
    judged = [f"{figure}@{number}" for number in at for figure in ("overall", "sharp")]
    return ["epe", "epe still", "flicker", "flick still", "overall", "moved", *judged, "s/frame", "stills"]


@dataclass
class Sequence:
    """What was seen of a sequence: the frames to be judged, by number, the motion of each pair, and seconds."""

    kept: dict[int, Tensor]
    errors: list[float]
    flicker: list[float]
    wall: float
    cpu: float


def watched(task: Task, method: Method, count: int, keep: set[int], title: str) -> Sequence:
    """Make `count` frames, comparing each with the one before it, and keep some."""
    seen = Sequence({}, [], [], 0.0, 0.0)
    frames = islice(method.frames(task), count)
    for number, (before, after) in enumerate(pairwise(timed(frames, seen, title, count))):
        seen.kept |= {k: frame for k, frame in ((number, before), (number + 1, after)) if k in keep}
        error, flicker = motion(before, after, task, number)
        seen.errors.append(error)
        seen.flicker.append(flicker)
    return seen


def timed(frames: Iterator[Tensor], seen: Sequence, title: str, count: int) -> Iterator[Tensor]:
    """The frames in 8 bits; the seconds that those after the first take go to `seen`."""
    for number in range(count):
        tables.progress(f"{title}: frame {number}")
        wall, cpu = time.perf_counter(), time.process_time()
        frame = next(frames)
        if number:
            seen.wall += (time.perf_counter() - wall) / (count - 1)
            seen.cpu += (time.process_time() - cpu) / (count - 1)
        yield in_8_bits(frame)


def in_8_bits(image: Tensor) -> Tensor:
    return (image.clamp(0, 1) * 255).round() / 255


def motion(before: Tensor, after: Tensor, task: Task, number: int) -> tuple[float, float]:
    """End-point error and flicker of a pair of frames."""
    forward = task.field(number, task.shape)
    border = min(BORDER, min(task.shape) // 4)
    inner = (slice(None), *(slice(border, side - border) for side in task.shape))
    change = after - flow.warp(before, flow.lookup(forward).coordinates)
    deviation = float(task.exemplar.std())
    error = flow.end_point_error(flow.seen(before, after), forward, border=border)
    return error, float(mean(change[inner].abs())) / deviation


@dataclass(frozen=True)
class Still:
    """The first frame, what it and itself moved by half a pixel measure, one warp's motion, and the cpu seconds."""

    image: Tensor
    figures: dict[str, float]
    moved: dict[str, float]
    motion: tuple[float, float]
    cpu: float


def still_of(task: Task) -> Still:
    cpu = time.process_time()
    optimize(Exemplar.of(task.exemplar), task.shape, seed=task.seed)
    cpu = time.process_time() - cpu
    image = in_8_bits(next(kwatra_frames(task)))
    once = flow.lookup(task.field(0, task.shape)).coordinates
    warped = in_8_bits(flow.warp(image, once, "lanczos"))
    half = flow.warp(image, pixel_coordinates(task.shape) + 0.5, "lanczos")
    figures, moved = (measure(in_8_bits(picture), task.exemplar) for picture in (image, half))
    return Still(image, figures, moved, motion(image, warped, task, 0), cpu)


def figures_of(task: Task, still: Still, sequence: Sequence, stands: dict[int, int], at: list[int]) -> dict[str, float]:
    """A row of the table. stands: which frame of the sequence is judged as frame N."""
    epe, flicker = (sum(values) / len(values) for values in (sequence.errors, sequence.flicker))
    figures = {"epe": epe, "epe still": still.motion[0], "flicker": flicker, "flick still": still.motion[1]}
    figures["overall"] = still.figures["overall"]
    figures["moved"] = still.moved["overall"] / max(still.figures["overall"], 1e-9)
    for number in at:
        frame = sequence.kept.get(stands.get(number, -1))
        judged = None if frame is None else measure(frame, task.exemplar)
        for name, figure in (("overall", "overall"), ("sharp", "sharpness")):
            value = math.nan if judged is None else judged[figure] / max(still.figures[figure], 1e-9)
            figures[f"{name}@{number}"] = value
    return figures | {"s/frame": sequence.wall, "stills": sequence.cpu / max(still.cpu, 1e-9)}


def bench(
    exemplars: dict[str, Tensor], fields: dict[str, flow.Field], arguments: argparse.Namespace
) -> Iterator[tables.Row]:
    """Run every method on every exemplar and field; frames go to the folder `arguments.write`, if there is one."""
    for exemplar, image in exemplars.items():
        for name, field in fields.items():
            task = Task(image, field, arguments.size, arguments.preset, arguments.seed)
            still = still_of(task)
            for chosen in arguments.methods:
                method = METHODS[chosen]
                count = min(arguments.frames, arguments.short) if method.few else arguments.frames
                stands = {n: 1 + k % (count - 1) if method.alike else n for k, n in enumerate(arguments.at)}
                keep = {0, *stands.values(), *(max(number - 1, 0) for number in stands.values())}
                title = f"{exemplar} {name} {chosen}"
                sequence = watched(task, method, count, keep, title)
                if arguments.write is not None:
                    write_frames(arguments.write / title.replace(" ", "_").replace(":", "-"), task, sequence)
                figures = figures_of(task, still, sequence, stands, arguments.at)
                yield tables.Row(f"{exemplar} {name}", chosen, "", figures)


def write_frames(folder: Path, task: Task, sequence: Sequence) -> None:
    """The judged frames and those before them, the exemplar, and the flow at the last of them."""
    folder.mkdir(parents=True, exist_ok=True)
    kind = tables.eight_bit(task.exemplar)
    write_image(folder / "exemplar.png", task.exemplar, kind, overwrite=True)
    for number, frame in sequence.kept.items():
        write_image(folder / f"{number:04d}.png", frame, kind, overwrite=True)
    last = max(max(sequence.kept) - 1, 0)
    write_flow(folder / "flow.npy", task.field(last, task.shape), overwrite=True)


def carried_exemplars() -> dict[str, Tensor]:
    """Brick and gravel of scikit-image, and stones made in code, (C, 160, 160)."""
    return {make.__name__: make(SIDE) for make in (brick, gravel, pebbles)}


def parsed(words: list[str] | None) -> argparse.Namespace:
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("exemplars", nargs="*", help="image files, names, or text files that list them")
    parser.add_argument("--images", type=Path, default=Path(), help="folder where names, with .png, are looked for")
    parser.add_argument("--fields", nargs="+", default=FIELDS, help=f"names or files ({' '.join(FIELDS)})")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="METHOD")
    parser.add_argument("--size", type=tables.size, default=(256, 256), help="of the frames, WIDTHxHEIGHT (256x256)")
    parser.add_argument("--frames", type=tables.several, default=301, help="how many (301)")
    parser.add_argument("--at", type=tables.numbers, default=[25, 100, 300], help="frames to be judged (25,100,300)")
    parser.add_argument("--short", type=tables.several, default=26, help="so many of methods that are slow (26)")
    parser.add_argument("--preset", choices=flow.PRESETS, default="default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", type=Path, metavar="DIR", help="write the judged frames, each with the one before")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    return parser.parse_args(words)


def run(arguments: argparse.Namespace) -> None:
    given = tables.given_exemplars(arguments.exemplars, arguments.images)
    exemplars = given or carried_exemplars()
    fields = {Path(name).stem: field_of(name, resample=True) for name in arguments.fields}
    width = max(map(len, exemplars)) + 1 + max(map(len, fields))
    rows = tables.print_table(bench(exemplars, fields, arguments), figure_names(arguments.at), width)
    tables.write_json(rows, arguments.json)


def main(words: list[str] | None = None) -> int:
    arguments = parsed(words)
    return tables.exit_code("bench_flow", lambda: run(arguments))


if __name__ == "__main__":
    sys.exit(main())
