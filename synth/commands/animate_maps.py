"""Maps that go along with a texture that flows: `--also` of `kwatra animate`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

from flow.animation.carrying import turns
from kwatra.base import InputError
from synth.commands.framewise import Track, digest
from synth.io.images import to_pixels
from synth.io.kinds import Kind
from synth.io.videos import VIDEO_SUFFIXES, read_video
from synth.texture.form import Form
from synth.texture.maps import read_map
from synth.texture.normals import is_normal, points_down, turned_normals


@dataclass(frozen=True)
class Along:
    """A map of the exemplars: its name, values in [0, 1] for each (M, H, W) or (M, T, H, W), and where it goes.

    form: takes them back to what the file holds.
    """

    name: str
    values: list[Tensor]
    form: Form[Tensor]
    kind: Kind
    output: Path

    @property
    def track(self) -> Track:
        """Where its frames go."""
        floats = self.kind.dtype.startswith("f")
        return Track(self.output, self.kind, (self.form.low, self.form.high) if floats else (0.0, 1.0))

    @property
    def digest(self) -> str:
        """What tells it from other maps."""
        return f"{self.name} {' '.join(digest(values, self.kind) for values in self.values)}"

    def drawn(self, values: Tensor, source: Tensor, shown: Tensor) -> Tensor:
        """A frame's values (M, H, W) as the file is to hold them; 0 where nothing is shown (H, W).

        Normals turn with what the flow turns: source (2, H, W) says where each pixel is read.
        """
        restored = self.form.restored(values)
        if is_normal(self.name) and len(restored) > 1:
            signed = self.kind.dtype.startswith("f") and self.form.low < 0
            centered = restored if signed else 2 * restored - 1
            turned = turned_normals(centered.movedim(0, -1).numpy(), turns(source).numpy(), points_down(self.name), 0.0)
            there = torch.from_numpy(turned).movedim(-1, 0).clamp(-1, 1)
            restored = there if signed else (there + 1) / 2
        return torch.where(shown, restored, 0.0)


def read_along(request: str, exemplars: Sequence[Tensor], output: Path) -> Along:
    """What `--also NAME=FILE[,FILE]` asks for, of exemplars (C, H, W), or of a video (C, T, H, W) a video.

    The map's frames go beside `output`, as OUT_NAME in its form.
    """
    if exemplars[0].ndim == 4:
        name, values, kind = _of_video(request, exemplars[0])
    else:
        sizes = [(exemplar.shape[1], exemplar.shape[2]) for exemplar in exemplars]
        carried = read_map(request, sizes, output)
        name, values, kind = carried.name, [to_pixels(array) for array in carried.arrays], carried.kind
    form: Form[Tensor] = Form.of(values)
    beside = output.with_name(f"{output.stem}_{name}{output.suffix}" if output.suffix.lower() in VIDEO_SUFFIXES
                              else f"{output.name}_{name}")  # fmt: skip
    return Along(name, [form.normalized(each) for each in values], form, kind, beside)


def _of_video(request: str, exemplar: Tensor) -> tuple[str, list[Tensor], Kind]:
    name, equals, file = request.partition("=")
    if not (name and equals and file):
        raise InputError(f"--also is {request!r}; write NAME=VIDEO, for example depth=smoke_depth.mp4")
    clip = read_video(Path(file))
    if clip.frames.shape[1:] != exemplar.shape[1:]:
        lengths = ["x".join(map(str, reversed(frames.shape[1:]))) for frames in (clip.frames, exemplar)]
        raise InputError(f"{file} is {lengths[0]} (WxHxT) but its exemplar {lengths[1]}; a map has its length and size")
    return name, [clip.frames], clip.kind
