"""`kwatra score`: how well outputs match their exemplar, images or videos."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.parsing import Subparsers, file
from synth.commands.report import score_table
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Kind

LOADS = ("synth.io.images", "synth.io.videos", "kwatra.scoring")

_MOST_PIXELS, _MOST_FRAMES_PIXELS = 2**24, 2**25
"""Time grows with pixels and with the cube of channels: these take a minute on one core, and five minutes of video."""

_COLORLESS = 0.05
"""Channels that differ by at most this show no color; H.264 makes grays differ by .01 to .02."""

_COLUMNS = """columns:
  forward      distance from what is seen in the output to the likest in the exemplar: lower is better, 0 is perfect
  coverage     the same from the exemplar to the output, whether all of it appears: lower is better
  wasserstein  whether all appears as often as in the exemplar: lower is better
  sharpness    gradients of the output over those of the exemplar: 1 is right, below is blurred, above is too rough
  overall      mean of forward, coverage, wasserstein and what sharpness is off 1: lower is better, to be read with copy
Distances are in standard deviations of the exemplar: 1 is hopeless.
images only:
  copy         part of the exemplar that the output's verbatim copies are large on average: lower is more of its own
  use          how evenly all parts of the exemplar are used, 0 to 1: higher is better
videos, of which windows of 4 frames are compared:
  change       change from frame to frame over the exemplar's: 1 is right, 0 a still, above is restless
  flicker      change of that change over the exemplar's: 1 is right, below too smooth, above it flickers
  tempo        how far off the pace is, over 1 to 8 frames and from fine to coarse: 0 is right, 0.1 is 10%
  order        whether frames follow from each other as the exemplar's do: 0 is right, near 1 shuffled or frozen
  direction    whether things go the exemplar's way: 0 is right, 1 no way or to and fro, 2 backwards
  replay       part of what moves that plays 8 frames or more of the exemplar again: lower is more of its own
  loop         step from the last frame to the first over the exemplar's largest: 1 or less joins (nothing if no loop)
  overall      the mean above with tempo, order, direction and what change is off 1: to be read with replay
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "score",
        help="how well outputs match their exemplar",
        description="Measure synthesized images against their exemplar, or videos against theirs.",
        epilog=_COLUMNS,
    )
    parser.add_argument(
        "exemplar",
        type=file,
        metavar="EXEMPLAR",
        help="image of the texture, or a video (.mp4, .gif, .webm, .mov, .mkv, .avi and others, or a folder of frames)",
    )
    parser.add_argument("outputs", nargs="+", type=file, metavar="OUTPUT", help="image, or video, to measure")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def run(arguments: argparse.Namespace) -> str:
    """A table, or JSON of one object per output file."""
    from kwatra import measure

    _check_alike(arguments.exemplar, arguments.outputs)
    exemplar, kind = _read(arguments.exemplar)
    pairs = {}
    for path in arguments.outputs:
        output, its = _read(path)
        like = exemplar
        if min(len(like), len(output)) == 1:  # video files hold grays in three channels
            like, output = (pixels.mean(0, keepdim=True) if _is_gray(pixels) else pixels for pixels in (like, output))
        if len(output) != len(like):
            raise synth.InputError(
                f"{path} holds {its} but {arguments.exemplar} holds {kind}; an output has its exemplar's channels"
            )
        pairs[str(path)] = output, like
    scores = {path: measure(*pair) for path, pair in pairs.items()}
    if arguments.json:
        return json.dumps([{"output": path, **row} for path, row in scores.items()], indent=2)
    return score_table(scores)


def _is_gray(pixels: "Tensor") -> bool:
    """Whether three channels show no color, but for what compression makes."""
    return len(pixels) == 3 and float((pixels.amax(0) - pixels.amin(0)).max()) <= _COLORLESS


def _check_alike(exemplar: Path, outputs: list[Path]) -> None:
    """Refuse stills beside videos: they are judged by other figures."""
    words = {False: "an image", True: "a video"}
    asked = io.is_video(exemplar)
    for path in outputs:
        if path.exists() and exemplar.exists() and io.is_video(path) != asked:
            raise synth.InputError(
                f"{path} is {words[not asked]} but {exemplar} is {words[asked]}; "
                "measure images against an image, and videos against a video"
            )


def _read(path: Path) -> tuple["Tensor", "Kind"]:
    """Pixels (C, H, W) of an image or (C, T, H, W) of a video, and their kind; refuses what would take hours."""
    if io.is_video(path):
        clip = io.read_video(path)
        pixels, kind, most, limit = clip.frames, clip.kind, _MOST_FRAMES_PIXELS, "2^25 pixels in all frames"
    else:
        picture = io.read_image(path)
        pixels, kind, most, limit = picture.pixels, picture.kind, _MOST_PIXELS, "2^24 pixels (4096x4096)"
    from kwatra.scoring import CHANNELS, WINDOW

    channels, *frames, height, width = pixels.shape
    if min(height, width) < WINDOW:
        raise synth.InputError(f"{path} is {width}x{height}; at least {WINDOW}x{WINDOW} pixels are measured")
    if pixels[0].numel() > most or channels > CHANNELS:
        length = f" and {counted(frames[0], 'frame')} long" if frames else ""
        raise synth.InputError(
            f"{path} is {width}x{height} with {counted(channels, 'channel')}{length}; at most {limit} and "
            f"{CHANNELS} channels are measured, so crop it or leave some out"
        )
    return pixels, kind
