"""`kwatra animate`: frames are kept one by one in a folder; a video is made of them when all are there.

The folder of a video stands beside it as OUT.frames and goes when the video is whole.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from torch import Tensor

import flow
from kwatra import Exemplar
from kwatra.base import InputError
from synth.commands.animate_arguments import FRAMES
from synth.commands.animate_inputs import Inputs, name_of, read_inputs, settings_of
from synth.commands.progress import work_line
from synth.commands.synth import set_up
from synth.io.frames import FramesFolder
from synth.io.images import write_files
from synth.io.videos import FILE_SUFFIXES, check_video_output, video_writer
from synth.texture.images import PRESETS

Report = Callable[[str, float], None]


def run_animate(arguments: argparse.Namespace) -> str:
    """`kwatra animate`: returns the summary."""
    set_up(arguments.device, arguments.threads)
    if arguments.loop is not None and arguments.fill_from is not None:
        raise InputError(
            "--loop leads back to the first frame, but with --fill-from that is empty; leave one of them out"
        )
    inputs = read_inputs(arguments)
    output = arguments.output or Path(f"{arguments.exemplar.stem}_{name_of(arguments.flow)}.mp4")
    job = _Job(arguments, inputs, output)
    after = job.checked()
    frames = job.frames(after)
    done = 0 if after is None else after.number + 1
    if done == job.total and not job.video:
        return f"{output} has its {done} frames already; there is nothing to do"
    began = time.perf_counter()
    with work_line(f"{arguments.exemplar.name}, {arguments.flow}") as report:
        job.run(frames, done, report)
    took = time.perf_counter() - began
    height, width = inputs.shape
    made = job.total - done
    now = f", {made} of them now," if done else ""
    each = f" ({took / made:.2f} s per frame)" if made else ""
    return f"wrote {output}: {job.total} frames of {width}x{height}{now} in {took:.1f} s{each}"


class _Job:
    """What is to be made, and where it is kept meanwhile."""

    def __init__(self, arguments: argparse.Namespace, inputs: Inputs, output: Path) -> None:
        self.arguments, self.inputs, self.output = arguments, inputs, output
        self.total: int = arguments.loop or arguments.frames or FRAMES
        self.video = output.suffix.lower() in FILE_SUFFIXES
        place = output.with_name(f"{output.name}.frames") if self.video else output
        self.folder = FramesFolder(place, inputs.exemplar.kind, settings_of(arguments, inputs))

    def checked(self) -> flow.State | None:
        """Refuse what could not be written; returns the state to go on after, if so asked."""
        resume, overwrite = self.arguments.resume, self.arguments.overwrite
        if not self.output.is_dir() or self.video:
            if resume and self.video and self.output.exists() and not self.folder.path.exists():
                raise InputError(f"{self.output} is whole, there is nothing to resume; make it anew with --overwrite")
            check_video_output(self.output, overwrite or not self.video)
        if not resume:
            self.folder.check_new(overwrite)
            return None
        state = self.folder.state()
        if state.number >= self.total:
            raise InputError(
                f"{self.folder.path} has {state.number + 1} frames already, more than the {self.total} asked for; "
                f"give --frames {state.number + 1} or more"
            )
        return state

    def frames(self, after: flow.State | None) -> Iterator[flow.Frame]:
        """The frames to make, none of them made yet."""
        arguments, inputs = self.arguments, self.inputs
        device = arguments.device
        exemplar = Exemplar.of(inputs.form.normalized(inputs.exemplar.pixels), device=device)
        first = None if inputs.first is None else inputs.form.normalized(inputs.first.pixels).to(device)
        if after is not None:
            after = after.to(device)
        make, more = (flow.animate, {"enter": arguments.fill_from}) if arguments.loop is None else (flow.loop, {})
        return make(
            exemplar,
            inputs.field,
            inputs.shape,
            frames=self.total,
            first=first,
            mask=inputs.mask,
            renewing=flow.PRESETS[arguments.preset],
            synthesis=PRESETS[arguments.preset][0],
            seed=arguments.seed,
            after=after,
            **more,
        )

    def run(self, frames: Iterator[flow.Frame], done: int, report: Report) -> None:
        """Make the frames, of which `done` are there, and the video; a KeyboardInterrupt says what is left."""
        begun = done > 0
        if begun:
            self.folder.clear(done - 1)
        began = time.perf_counter()
        try:
            for number, frame in enumerate(frames, done):
                if not begun:
                    self.folder.clear()
                    begun = True
                self.folder.add(self.inputs.drawn(frame), frame.state)
                rate = (number + 1 - done) / (time.perf_counter() - began)
                report(f"frame {number + 1} of {self.total}, {rate:.1f} frames/s", (number + 1) / self.total)
            if self.video:
                write_files({self.output: video_writer(self.output, self._shown(report), self.arguments.fps)})
                self.folder.remove()
        except KeyboardInterrupt:
            count = self.folder.count() if begun else 0
            if not count:
                raise
            raise KeyboardInterrupt(
                f"interrupted, {count} of {self.total} frames are whole in {self.folder.path}; --resume goes on"
            ) from None

    def _shown(self, report: Report) -> Iterator[Tensor]:
        """The frames of a video, from black 0 to white 1."""
        low, high = self.inputs.extremes
        for number, frame in enumerate(self.folder.frames(self.total), 1):
            report(f"writing {self.output.name}", number / self.total)
            yield (frame - low) / ((high - low) or 1.0)
