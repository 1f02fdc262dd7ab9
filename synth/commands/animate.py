"""`kwatra animate`: frames are kept one by one in a folder; a video is made of them when all are there.

The folder of a video stands beside it as OUT.frames and goes when the video is whole.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import check_disk, finish, refuse_unused, set_up
from synth.commands.parsing import Subparsers, add_common, file, rate, size, whole
from synth.commands.progress import work_line
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    import flow
    from synth.commands.animate_inputs import Inputs

LOADS = ("synth.commands.animate_inputs", "synth.io.frames", "synth.io.videos")

Report = Callable[[str, float], None]

_FRAMES, _FPS = 100, 25.0

_EPILOG = """examples:
  kwatra animate brick.png --flow rotation                  100 frames, as brick_rotation.mp4
  kwatra animate brick.png --flow uniform:90 --loop 60 -o falling.gif
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
    add("exemplar", type=file, metavar="EXEMPLAR", help="an image of the texture; or a video (.mp4, .gif) or a folder "
        "of frames, whose texture lives on while it flows")  # fmt: skip
    add("--flow", required=True, metavar="FIELD", help="uniform:ANGLE, rotation, sink, ... (another name lists them "
        "all), or a file: .flo, .png (KITTI), .npy or .npz")  # fmt: skip
    add("--speed", type=float, metavar="PX", help="px per frame of the fastest pixel (default: 2; a file's own)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: that of the files given, a "
        "video's own, or 256x256)")  # fmt: skip
    add("--resample", action="store_true", help="stretch a file's flow over frames of another size")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--frames", type=whole(1), metavar="N", help=f"how many frames (default: {_FRAMES})")
    length.add_argument("--loop", type=whole(2), metavar="N", help="N frames of which the last leads into the first")
    add("--obstacle", type=_obstacle, metavar="WHAT", help="what is flowed around: an image, white where the obstacle "
        "is; or disc, in the middle; or disc:X,Y,RADIUS in pixels")  # fmt: skip
    begin = parser.add_mutually_exclusive_group()
    begin.add_argument("--first", type=file, metavar="IMAGE", help="a picture to begin with, of the frames' size")
    begin.add_argument("--fill-from", choices=("left", "right", "top", "bottom", "all"), help="begin with an empty "
        "frame that texture enters from there")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="an .mp4 or .gif to write, or a folder for PNG frames, TIFF "
        "where the exemplar needs it (default: EXEMPLAR_FIELD.mp4 in this folder)")  # fmt: skip
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
    from synth.commands.animate_inputs import frames_of, name_of, read_inputs

    set_up(arguments)
    if arguments.loop is not None and arguments.fill_from is not None:
        raise synth.InputError(
            "--loop leads back to the first frame, but with --fill-from that is empty; leave one of them out"
        )
    if arguments.published:
        refuse_unused(arguments, ["fill_from", "first"], "begins an animation, but what was --published has no such")
        if arguments.preset != "default":
            raise synth.InputError("--preset says how to renew, but what was --published renews nothing; leave it out")
    inputs = read_inputs(arguments)
    job = _Job(arguments, inputs, arguments.output or Path(f"{arguments.exemplar.stem}_{name_of(arguments.flow)}.mp4"))
    after = job.checked()
    frames = frames_of(arguments, inputs, job.total, after)
    done = 0 if after is None else after.number + 1
    if done == job.total and not job.video:
        return f"{job.output} has its {counted(done, 'frame')} already; there is nothing to do"
    began = time.perf_counter()
    with work_line(f"{arguments.exemplar.name}, {arguments.flow}") as report:
        job.run(frames, done, report)
    took = time.perf_counter() - began
    height, width = inputs.shape
    made = job.total - done
    now = f", {made} of them now," if done else ""
    each = f" ({took / made:.2f} s per frame)" if made else ""
    return f"wrote {job.output}: {counted(job.total, 'frame')} of {width}x{height}{now} in {took:.1f} s{each}"


class _Job:
    """What is to be made, and where it is kept meanwhile."""

    def __init__(self, arguments: argparse.Namespace, inputs: "Inputs", output: Path) -> None:
        self.arguments, self.inputs, self.output = arguments, inputs, output
        self.total: int = arguments.loop or arguments.frames or _FRAMES
        self.video = output.suffix.lower() in io.VIDEO_SUFFIXES
        place = output.with_name(f"{output.name}.frames") if self.video else output
        self.folder = io.FramesFolder(place, inputs.exemplar.kind, inputs.settings)

    def checked(self) -> "flow.State | None":
        """Refuse what could not be written; returns the state to go on after, if so asked and there is one."""
        resume, overwrite, folder = self.arguments.resume, self.arguments.overwrite, self.folder
        if not self.video:
            refuse_unused(
                self.arguments, ["fps"], f"is for .mp4 and .gif but {self.output} is to be a folder of frames"
            )
        if not self.output.is_dir() or self.video:
            if resume and self.video and self.output.exists() and not folder.path.exists():
                raise synth.InputError(
                    f"{self.output} is whole, there is nothing to resume; make it anew with --overwrite"
                )
            io.check_video_output(self.output, overwrite or not self.video)
        folder.check(overwrite or resume)
        state = folder.state() if resume else None
        done = 0 if state is None else state.number + 1
        if done > self.total:
            raise synth.InputError(
                f"{folder.path} has {counted(done, 'frame')} already, more than the {self.total} asked for; "
                f"give --frames {done} or more"
            )
        length = f"an animation of {counted(self.total, 'frame')}"
        check_disk((self.total - done) * self._least_bytes(), folder.path.absolute().parent, length, "ask for fewer")
        return state

    def _least_bytes(self) -> int:
        """What a frame takes at least on a disk: textures compress to about half, so a quarter."""
        height, width = self.inputs.shape
        return height * width * self.inputs.exemplar.kind.bytes_per_pixel // 4

    def run(self, frames: "Iterator[flow.Frame]", done: int, report: Report) -> None:
        """Make the frames, of which `done` are there, and the video; a KeyboardInterrupt says what is left."""
        begun = done > 0
        if begun:
            self.folder.clear(done - 1)
        began = time.perf_counter()
        try:
            for number, frame in enumerate(frames, done):
                if not begun:
                    self.folder.begin()
                    begun = True
                self.folder.add(self.inputs.drawn(frame), frame.state)
                rate = (number + 1 - done) / (time.perf_counter() - began)
                report(f"frame {number + 1} of {self.total}, {rate:.1f} frames/s", (number + 1) / self.total)
            if self.video:
                fps = self.arguments.fps or self.inputs.rate or _FPS
                finish({self.output: io.video_writer(self.output, self._shown(report), fps)})
                self.folder.remove()
        except KeyboardInterrupt:
            count = self.folder.count() if begun else 0
            if not count:
                raise
            raise KeyboardInterrupt(
                f"interrupted with {count} of {self.total} frames whole in {self.folder.path}; --resume goes on"
            ) from None

    def _shown(self, report: Report) -> "Iterator[Tensor]":
        """The frames of a video, from black 0 to white 1."""
        low, high = self.inputs.extremes
        for number, frame in enumerate(self.folder.frames(self.total), 1):
            report(f"writing {self.output.name}", number / self.total)
            yield (frame - low) / ((high - low) or 1.0)
