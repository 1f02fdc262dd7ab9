"""`kwatra animate`: a texture that flows along a field, frame by frame."""

import argparse
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth.commands.checks import refuse_unused, set_up
from synth.commands.framewise import Framewise
from synth.commands.parsing import (
    Subparsers,
    add_common,
    add_scale,
    file,
    finite,
    frame_count,
    numbers,
    rate,
    size,
    whole,
)
from synth.commands.progress import work_line
from synth.commands.telling import Contributions
from synth.words import counted

if TYPE_CHECKING:
    import flow

LOADS = ("synth.commands.animate_inputs", "synth.io.frames", "synth.io.videos")

_FRAMES, _FPS = 100, 25.0

_EPILOG = """examples:
  kwatra animate brick.png --flow rotation                  100 frames, as brick_rotation.mp4
  kwatra animate brick.png --flow uniform:90 --loop 60 -o falling.gif
  kwatra animate keys.png --flow rotation --turn off        keys stay upright while they go round
  kwatra animate leaves.png --flow wind.flo --speed 2 --frames 1000 -o frames/
  kwatra animate smoke.mp4 --flow vortices --frames 300     its texture moves as told and lives on as it does there
  kwatra animate sand.png --flow uniform --obstacle disc --fill-from left
  kwatra animate leaves.png --flow wind.flo --speed 2 --frames 2000 -o frames/ --resume
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "animate",
        help="a texture that flows along a field",
        description="Make a video, or a folder of frames, of a texture that flows along a field without wearing out.\n"
        "Every frame is kept as soon as it is whole: what was interrupted, --resume goes on with.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("exemplars", nargs="+", type=file, metavar="EXEMPLAR", help="an image or several of one texture; or a video "
        "(.mp4, .gif, .webm, .mov, .mkv, .avi, ...) or a folder of frames, which lives on while it flows")  # fmt: skip
    add("--flow", required=True, metavar="FIELD", help="uniform:ANGLE, rotation, sink, ... (another name lists them "
        "all), or a file: .flo, .png (KITTI), .npy or .npz")  # fmt: skip
    add("--speed", type=finite, metavar="PX", help="px per frame of the fastest pixel (default: 2; a file's own)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: that of the files given, a "
        "video's own, or 256x256)")  # fmt: skip
    add("--resample", action="store_true", help="stretch a file's flow over frames of another size")
    length = parser.add_mutually_exclusive_group().add_argument
    length("--frames", type=frame_count(1), metavar="N", help=f"how many (default: {_FRAMES}, or a flow file's)")
    length("--loop", type=frame_count(2), metavar="N", help="N frames of which the last leads into the first")
    add("--obstacle", type=_obstacle, metavar="WHAT", help="what is flowed around: an image, white where the obstacle "
        "is; or disc, in the middle; or disc:X,Y,RADIUS in pixels")  # fmt: skip
    add("--background", type=file, metavar="IMAGE", help="what is seen around the texture (default: black, or gray)")
    begin = parser.add_mutually_exclusive_group()
    begin.add_argument("--first", type=file, metavar="IMAGE", help="a picture to begin with, of the frames' size")
    begin.add_argument("--fill-from", choices=("left", "right", "top", "bottom", "all"), help="begin with an empty "
        "frame that texture enters from there")  # fmt: skip
    add("--turn", choices=("on", "off"), help="whether the elements of a picture turn with the flow, or keep their "
        "directions (default: on where the picture prefers none, as gravel, and the flow hardly shears)")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="an .mp4, .gif, .webm or .mov, or a folder for PNG frames, "
        "TIFF where the exemplar needs it (default: EXEMPLAR_FIELD.mp4 in this folder)")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="carry a map of the exemplar along, frame by "
        "frame, to OUT_NAME; with several exemplars NAME=FILE1,FILE2; may be given again")  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored variants of the exemplar too")
    add("--rotate", type=numbers, default=(), metavar="DEG,...", help="use rotated variants too (--rotate=-90,90; "
        "default: none, but for videos with --published those that the flow asks for)")  # fmt: skip
    add_scale(parser)
    add("--fps", type=rate, metavar="F", help=f"frames a second of a video (default: as the exemplar, or {_FPS:g})")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another texture (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add("--published", action="store_true", help="as Kwatra's thesis has it, to compare with: the flow as an energy of "
        "each frame, or of a video's whole volume (equations 27 and 29)")  # fmt: skip
    add("--resume", action="store_true", help="go on after the last frame of an interrupted run, or a folder's; the "
        "result is the same as without the break")  # fmt: skip
    add_common(parser, threads=1)  # one frame's steps are too small to share


def _obstacle(text: str) -> "Path | tuple[float, ...]":
    """`disc`, `disc:X,Y,RADIUS` or a file."""
    name, colon, rest = text.partition(":")
    if name != "disc":
        return file(text)
    try:
        numbers = tuple(float(part) for part in rest.split(",")) if colon else ()
    except ValueError:
        numbers = (0.0,)
    if colon and not (len(numbers) == 3 and all(abs(n) < float("inf") for n in numbers) and numbers[2] > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no disc; write disc, or disc:X,Y,RADIUS as disc:80,60,20")
    return numbers


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    from synth.commands.animate_flow import name_of
    from synth.commands.animate_inputs import frames_of, read_inputs

    set_up(arguments)
    if arguments.loop is not None and arguments.fill_from is not None:
        raise synth.InputError(
            "--loop leads back to the first frame, but with --fill-from that is empty; leave one of them out"
        )
    if arguments.published:
        refuse_unused(arguments, ["fill_from", "first"], "begins an animation, but what was --published has no such")
        refuse_unused(arguments, ["turn"], "is of copies that are carried, but what was --published carries none")
        refuse_unused(arguments, ["also"], "goes along with what is renewed, but what was --published renews nothing")
        if len(arguments.exemplars) > 1:
            raise synth.InputError("what was --published has one exemplar; give one")
        if arguments.preset != "default":
            raise synth.InputError("--preset says how to renew, but what was --published renews nothing; leave it out")
    if arguments.obstacle is None and arguments.fill_from is None:
        refuse_unused(arguments, ["background"], "is seen where there is no texture, but there is some everywhere")
    source = arguments.exemplars[0]
    output = arguments.output or Path(f"{source.stem}_{name_of(arguments.flow)}.mp4")
    inputs = read_inputs(arguments, output)
    job = Framewise(
        arguments,
        inputs.tracks(output),
        inputs.asked.length(arguments, _FRAMES),
        inputs.shape,
        inputs.settings,
        inputs.rate or _FPS,
        "an animation",
    )
    after = job.checked()
    done = 0 if after is None else after.number + 1
    if done == job.total and not job.video:
        return f"{job.output} has its {counted(done, 'frame')} already; there is nothing to do"
    began, told = time.perf_counter(), Contributions(arguments.exemplars)
    with work_line(f"{source.name}, {arguments.flow}") as report:
        frames = frames_of(arguments, inputs, job.total, after)
        job.run(((inputs.drawn(frame), frame.state) for frame in _counted(frames, told)), done, report)
    return job.summary(done, time.perf_counter() - began) + told.said()


def _counted(frames: "Iterable[flow.Frame]", told: Contributions) -> "Iterator[flow.Frame]":
    """The frames, of which is told what comes from where: of what was made now, not of frames that were there."""
    for frame in frames:
        told.add(frame.source[0].where(frame.state.inside, -1).cpu().numpy())
        yield frame
