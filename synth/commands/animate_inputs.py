"""What `kwatra animate` is given, read and checked: the exemplar, the flow, what is flowed around, the first frame."""

import argparse
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

import flow
from kwatra import Exemplar
from kwatra.base import InputError
from synth.commands.animate_flow import AskedFlow
from synth.commands.animate_maps import Along, read_along
from synth.commands.checks import check_size
from synth.commands.framewise import Track, digest, versions
from synth.io.alpha import premultiplied, straight
from synth.io.images import Picture, read_image, read_mask
from synth.io.kinds import Kind
from synth.io.raising import raised
from synth.io.videos import is_video, read_video
from synth.texture.form import Form
from synth.texture.illumination import under_even_light
from synth.texture.normals import is_normal
from synth.texture.work import PRESETS

Shape = tuple[int, int]

Obstacle = Path | tuple[float, ...]
"""An image, or a disc: (x, y, radius), or () for the one in the frame's middle."""

_SIZE = (256, 256)
_LEAST = 4


@dataclass(frozen=True)
class Inputs:
    """What an animation is made of.

    exemplars: of one kind, (C, H, W) each, or one (C, T, H, W) of a video, of which rate says how many frames play in a
    second. asked: the flow as --flow has it; field: the same, bent around the obstacle. shape: (H, W) of the frames.
    mask (H, W): False where the obstacle is; None where there is none. first: the pixels of a picture to begin with.
    form: takes the exemplars' pixels to [0, 1] and back. background (C, H, W): what is seen where there is no texture;
    None where nothing is. maps: what goes along. settings: all that decides what the frames look like, by names that a
    user knows; of files, what they hold.

    Pixels are mixed with their colors multiplied by alpha, so that what cannot be seen colors nothing.
    """

    exemplars: list[Tensor]
    kind: Kind
    asked: AskedFlow
    field: flow.Field
    shape: Shape
    mask: Tensor | None
    first: Tensor | None
    form: Form[Tensor]
    background: Tensor | None
    maps: list[Along]
    settings: Mapping[str, str]
    rate: float | None = None

    @property
    def video(self) -> bool:
        """Whether the texture is that of a video."""
        return self.exemplars[0].ndim == 4

    @property
    def extremes(self) -> tuple[float, float]:
        """What is black and white: 0 and 1, or the least and largest value of an exemplar of floats."""
        return (self.form.low, self.form.high) if self.kind.dtype.startswith("f") else (0.0, 1.0)

    def tracks(self, output: Path) -> list[Track]:
        """Where the pictures and the maps go."""
        return [Track(output, self.kind, self.extremes), *(along.track for along in self.maps)]

    def drawn(self, frame: flow.Frame) -> list[Tensor]:
        """A frame's pixels (C, H, W) and maps (M, H, W) as files are to hold them."""
        inside = frame.state.inside.cpu()
        pictures = [self._picture(frame.image.cpu(), inside)]
        if frame.also is None:
            return pictures
        maps = frame.also.cpu().split([len(along.values[0]) for along in self.maps])
        source, shown = frame.state.source.cpu(), inside if self.mask is None else inside & self.mask
        return pictures + [along.drawn(values, source, shown) for along, values in zip(self.maps, maps, strict=True)]

    def _picture(self, image: Tensor, inside: Tensor) -> Tensor:
        """Pixels with what is seen where there is no texture.

        It is the background, or else black, and gray where the obstacle is; transparent where there can be alpha.
        """
        low, high = self.extremes
        opaque = "A" not in self.kind.channels
        pixels = straight(self.form.restored(image), self.kind)
        if self.background is not None:
            return torch.where(inside if self.mask is None else inside & self.mask, pixels, self.background)
        pixels = torch.where(inside, pixels, low if opaque else 0.0)
        return pixels if self.mask is None else torch.where(self.mask, pixels, (low + high) / 2 if opaque else 0.0)


def read_inputs(arguments: argparse.Namespace, output: Path) -> Inputs:
    """Read all files that the arguments name; InputError for what does not fit together. output: where frames go."""
    path = arguments.exemplars[0]
    exemplars, kind, behind, rate = _read_exemplars(arguments)
    first = None if arguments.first is None else _read_first(arguments.first, path, kind)
    drawn = read_mask(arguments.obstacle) if isinstance(arguments.obstacle, Path) else None
    given = {arguments.obstacle: drawn, arguments.first: None if first is None else first.pixels,
             arguments.background: behind}  # fmt: skip
    asked = AskedFlow.read(arguments)
    shape = _shape(arguments, given, asked, _size(exemplars[0]) if exemplars[0].ndim == 4 else _SIZE)
    field = asked.field(arguments.speed, arguments.resample)
    mask = None if arguments.obstacle is None else _mask(arguments.obstacle, drawn, shape)
    field = field if mask is None else flow.around(field, mask)
    mixed = [premultiplied(exemplar, kind) for exemplar in exemplars]
    begin = None if first is None else premultiplied(first.pixels, first.kind)
    maps = [read_along(request, exemplars, output) for request in arguments.also]
    turned = [along.name for along in maps if is_normal(along.name)]
    if turned and (arguments.mirror or arguments.rotate):
        raise InputError(f"--also {turned[0]} holds directions, which do not turn with variants of the exemplar; leave "
                         "out --mirror and --rotate, or that map")  # fmt: skip
    settings = {
        "exemplar": " ".join(digest(exemplar, kind) for exemplar in exemplars),
        **_settings(arguments, asked, shape, mask, first),
        "--background": "None" if behind is None else digest(behind, kind),
        "--also": " ".join(along.digest for along in maps),
    }
    form: Form[Tensor] = Form.of(mixed)
    return Inputs(mixed, kind, asked, field, shape, mask, begin, form, behind, maps, settings, rate)


def frames_of(
    arguments: argparse.Namespace, inputs: Inputs, total: int, after: flow.State | None
) -> Iterator[flow.Frame]:
    """The frames to make, none of them made yet, up to `total`; those behind a state."""
    device = arguments.device
    pixels = [inputs.form.normalized(exemplar) for exemplar in inputs.exemplars]
    variants = {"mirror": arguments.mirror, "rotate": arguments.rotate, "scale": arguments.scale or ()}
    exemplar = Exemplar.of(pixels, **variants, device=device)
    if arguments.published:
        return _published(arguments, inputs, exemplar if any(variants.values()) else pixels[0].to(device), total, after)
    if inputs.first is None:
        exemplar = under_even_light(exemplar, inputs.form.black)
    also = None
    if inputs.maps:
        values = zip(*(along.values for along in inputs.maps), strict=True)
        also = Exemplar.of([torch.cat(each) for each in values], **variants, device=device)
    first = None if inputs.first is None else inputs.form.normalized(inputs.first)
    make, more = (flow.animate, {"enter": arguments.fill_from}) if arguments.loop is None else (flow.loop, {})
    return make(
        exemplar,
        inputs.field,
        inputs.shape,
        frames=total,
        first=first,
        mask=inputs.mask,
        renewing=(flow.VIDEO_PRESETS if inputs.video else flow.PRESETS)[arguments.preset],
        synthesis=PRESETS[arguments.preset][0],
        seed=arguments.seed,
        after=after,
        also=also,
        turn=None if arguments.turn is None else arguments.turn == "on",
        **more,
    )


def _published(
    arguments: argparse.Namespace, inputs: Inputs, exemplar: Exemplar | Tensor, total: int, after: flow.State | None
) -> Iterator[flow.Frame]:
    """The frames as published, behind a state: made once more up to there, since all follow from one another."""
    mask = None if inputs.mask is None else inputs.mask.to(arguments.device)
    made = flow.published(
        exemplar, inputs.field, inputs.shape, total, seed=arguments.seed, loop=arguments.loop is not None, mask=mask
    )
    inside = torch.ones(inputs.shape, dtype=torch.bool) if inputs.mask is None else inputs.mask

    def frames() -> Iterator[flow.Frame]:
        for number, result in enumerate(made):
            if after is None or number > after.number:
                state = flow.State(number, result.where.flip(0).float(), inside, result.image)
                yield flow.Frame(**vars(result), state=state)

    return frames()


def _settings(
    arguments: argparse.Namespace, asked: AskedFlow, shape: Shape, mask: Tensor | None, first: Picture | None
) -> dict[str, str]:
    return {
        "--flow": asked.digest,
        "--speed": str(arguments.speed),
        "--size": "x".join(map(str, shape[::-1])),
        "--loop": str(arguments.loop),
        "--obstacle": "None" if mask is None else hashlib.sha256(mask.numpy().tobytes()).hexdigest(),
        "--fill-from": str(arguments.fill_from),
        "--first": "None" if first is None else digest(first.pixels, first.kind),
        "--seed": str(arguments.seed),
        "--preset": arguments.preset,
        "--turn": str(arguments.turn),
        "--published": str(arguments.published) + (f", {arguments.frames}" if arguments.published else ""),
        **{f"--{name}": str(getattr(arguments, name)) for name in ("mirror", "rotate", "scale", "device")},
        **versions(),
    }


def _read_exemplars(arguments: argparse.Namespace) -> tuple[list[Tensor], Kind, Tensor | None, float | None]:
    """Pictures, or a video and how many of its frames play in a second, of one kind; and what is seen behind them."""
    paths, behind = arguments.exemplars, arguments.background
    video = next((path for path in paths if is_video(path)), None)
    if video is None:
        files = [*paths, *([] if behind is None else [behind])]
        pixels, kind = raised([read_image(path) for path in files], files)
        return pixels[: len(paths)], kind, None if behind is None else pixels[-1], None
    if len(paths) > 1:
        raise InputError(f"{video} is a video, of which only one is animated; give images, or one video")
    clip = read_video(video)
    return [clip.frames], clip.kind, None if behind is None else _read_first(behind, video, clip.kind).pixels, clip.rate


def _read_first(path: Path, exemplar_path: Path, wanted: Kind) -> Picture:
    first = read_image(path)
    kind = first.kind
    if kind.channels != wanted.channels or kind.dtype.startswith("f") != wanted.dtype.startswith("f"):
        raise InputError(f"{path} holds {kind} but {exemplar_path} holds {wanted}; save it like the exemplar")
    return first


def _shape(
    arguments: argparse.Namespace, given: Mapping[Path, Tensor | None], asked: AskedFlow, default: Shape
) -> Shape:
    """(H, W): as asked, or that of the files, which must all have it, but for a flow that may be stretched."""
    sizes = {path: _size(image) for path, image in given.items() if image is not None}
    recorded = Path(asked.text)
    if asked.size is not None:
        default = asked.size
        if not arguments.resample:
            sizes = {recorded: default} | sizes
    shape = arguments.size or next(iter(sizes.values()), default)
    for path, size in sizes.items():
        if size != shape:
            cure = "stretch it with --resample" if path == recorded else "give both one size"
            raise InputError(
                f"{path} is {size[1]}x{size[0]} but the frames are to be {shape[1]}x{shape[0]}; "
                f"leave out --size, or {cure}"
            )
    if min(shape) < _LEAST:
        raise InputError(f"frames of {shape[1]}x{shape[0]} are too small; give at least {_LEAST} pixels a side")
    check_size(shape)
    return shape


def _mask(obstacle: Obstacle, drawn: Tensor | None, shape: Shape) -> Tensor:
    """Where texture belongs (H, W)."""
    if drawn is not None:
        name, mask = str(obstacle), ~drawn
    elif isinstance(obstacle, tuple) and obstacle:
        name, mask = "the disc", flow.disc_mask(shape, (obstacle[0], obstacle[1]), obstacle[2])
    else:
        name, mask = "the disc", flow.disc_mask(shape)
    if bool(mask.all()):
        raise InputError(f"{name} leaves the whole frame free; an obstacle is white in its image, or within the frame")
    if not bool(mask.any()):
        raise InputError(f"{name} covers the whole frame; leave some room for the texture")
    return mask


def _size(image: Tensor) -> Shape:
    return image.shape[-2], image.shape[-1]
