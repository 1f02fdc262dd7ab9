"""Image synthesis: a new picture of any size from pictures of one texture."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

import kwatra
from kwatra import Exemplar, InputError, Level, Progress, Result, Settings, Sum, TermLike
from synth.texture.form import Form, Image
from synth.texture.guidance import Guide

Map = TypeVar("Map", Tensor, np.ndarray)

PRESETS = {
    "fast": (Settings(seams=1, iterations=1, candidates=2, exact_pairs=1 << 22), 1),
    "default": (Settings(), 1),
    "best": (Settings(seams=12, iterations=6), 6),
}
"""Settings, and how many seeds are tried of which the best result is kept."""


@dataclass(frozen=True)
class Synthesis(Generic[Image]):
    """A synthesized picture.

    image: of the same kind as the exemplar. source (3, H, W) int64: for each pixel the number of the image it comes
    from, -1 for pixels that were given, and its row and column there. result: what the engine returned (its image
    normalized, channels first).
    """

    image: Image
    source: np.ndarray
    result: Result
    form: "Form[Image]"

    @property
    def stages(self) -> list[Image]:
        """The picture after each level, at that level's resolution, in the exemplar's kind and range."""
        return [self.form.restored(stage.image.cpu()) for stage in self.result.stages]

    def take(self, maps: Map | Sequence[Map]) -> Map:
        """Rearrange a map that belongs to the exemplar (one per image) just as the exemplar's pixels were.

        Arrays are (H, W) or (H, W, C), tensors (C, H, W); values and dtype stay exactly as they are. Pixels that come
        from no exemplar, because they were given, are 0.
        """
        several: list[Map] = [maps] if isinstance(maps, (Tensor, np.ndarray)) else list(maps)
        if len(several) <= self.source[0].max():
            raise InputError(f"{len(several)} maps were given, but the exemplar has more images; give one for each")
        arrays: list[np.ndarray] = [m.movedim(0, -1).numpy() if isinstance(m, Tensor) else m for m in several]
        made = taken(arrays, self.source)
        rearranged: Any = torch.from_numpy(made).movedim(-1, 0) if isinstance(several[0], Tensor) else made
        return rearranged  # the kind of maps that were given


def taken(maps: Sequence[np.ndarray], source: np.ndarray) -> np.ndarray:
    """Maps (H, W) or (H, W, C), one per image, rearranged as `source` (3, *S) says: image, row, column; -1 leaves 0."""
    made = np.zeros((*source.shape[1:], *maps[0].shape[2:]), maps[0].dtype)
    for number, array in enumerate(maps):
        here = source[0] == number
        made[here] = array[source[1][here], source[2][here]]
    return made


def synthesize(
    exemplar: Image | Sequence[Image],
    size: tuple[int, int] | None = None,
    *,
    preset: str = "default",
    seed: int = 0,
    tile: bool = False,
    start: Image | None = None,
    levels: str | Sequence[tuple[int, int]] | None = None,
    mirror: bool = False,
    rotate: Sequence[float] = (),
    scale: Sequence[float] = (),
    terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
    mask: Tensor | np.ndarray | None = None,
    guide: tuple[Any, Any] | list[tuple[Any, Any]] | None = None,
    guide_weight: float | Sequence[float] = 1.0,
    exemplar_mask: Tensor | np.ndarray | Sequence[Tensor | np.ndarray] | None = None,
    device: str = "cpu",
    callback: Callable[[Progress], None] | None = None,
) -> Synthesis[Image]:
    """A picture of `size` (height, width) that looks like the exemplar.

    exemplar: one or several images of a texture: tensors (C, H, W), or arrays (H, W) or (H, W, C), of any number of
    channels, floating point in any range or integer. The result is of the same kind and range.
    preset: "fast", "default" or "best". tile: the output repeats seamlessly in both directions. start: an image of
    the output's size to improve, instead of beginning anew. levels: (factor, window width) pairs, coarse to fine, or
    "thesis". mirror, rotate (degrees, counterclockwise), scale (factors): also copy from such copies of the exemplar.
    terms: control terms; their values are those of the exemplar scaled so that its least value is 0 and its largest
    is 1. mask: boolean (height, width), True where texture belongs. guide: a map of the exemplar (one for each) and
    one of the output, images of one kind and any number of channels: where the output's has a value, texture goes
    that has a like one in the exemplar; `size` may be left out, it is the output map's. guide_weight: what the guide
    counts beside the colors; 0.1 to 0.3 suits maps that vary smoothly. Several guides are a list, and may have a weight
    each. exemplar_mask: boolean, of the exemplar's size, True where it may be copied from; of several exemplars one for
    each. Same seed, same bits, for any number of threads. Raises InputError for what cannot be used.
    """
    images, form = _images(exemplar)
    settings, tries = _settings(preset, tile, levels)
    pictures = [form.normalized(image) for image in images]
    begin, channels = None if start is None else form.normalized(start), len(pictures[0])
    guidance = None if guide is None else Guide.joint(guide, guide_weight, pictures)
    size, weights = _size_of(size, guidance), None
    if guidance is not None:
        settings, terms = guidance.settings(settings, pictures, size), guidance.terms(terms, channels, device)
        pictures, weights = guidance.joined(pictures), guidance.weights(channels)
        begin = None if begin is None else guidance.beside(begin)
    masks = _masks(exemplar_mask)
    source = Exemplar.of(
        pictures, weights=weights, masks=masks, mirror=mirror, rotate=rotate, scale=scale, device=device
    )
    hidden, begin = (None if t is None else torch.as_tensor(t).to(device) for t in (mask, begin))
    run = partial(kwatra.optimize, source, size, settings=settings, terms=terms, mask=hidden, start=begin)
    result = _Runs(tries, seed, callback, channels).best(run, source)
    return Synthesis(form.restored(result.image.cpu()), result.source.cpu().numpy(), result, form)


def _settings(preset: str, tile: bool, levels: str | Sequence[tuple[int, int]] | None) -> tuple[Settings, int]:
    """The settings of a preset, and how many seeds it tries."""
    if preset not in PRESETS:
        raise InputError(f"the preset is {preset!r}; allowed are {', '.join(PRESETS)}")
    settings, tries = PRESETS[preset]
    return replace(settings, wrap=tile, levels=_levels(levels)), tries


def _images(exemplar: Image | Sequence[Image]) -> tuple[list[Image], Form[Image]]:
    """The exemplar's images, one or several, and their form."""
    images: list[Image] = [exemplar] if isinstance(exemplar, (Tensor, np.ndarray)) else list(exemplar)
    if not images:
        raise InputError("no exemplar was given; give at least one image")
    return images, Form.of(images)


def _masks(masks: Any) -> list[Tensor] | None:
    """Masks of the exemplars, given as one or as several, tensors or arrays."""
    if masks is None:
        return None
    several = [masks] if isinstance(masks, (Tensor, np.ndarray)) else masks
    return [torch.as_tensor(mask) for mask in several]


def _size_of(size: tuple[int, int] | None, guidance: Guide | None) -> tuple[int, int]:
    """The output's size: as asked, or that of its guide; where both are given they must agree."""
    if guidance is None:
        if size is None:
            raise InputError("no size was given; give the output's height and width")
        return size
    there = (guidance.output.shape[1], guidance.output.shape[2])
    if size is not None and tuple(size) != there:
        raise InputError(f"the size is {tuple(size)} but the guide's output map has {there}; leave the size out")
    return there


class _Runs:
    """Several runs of which the best is kept; of images, only the first `channels` are."""

    def __init__(self, count: int, seed: int, callback: Callable[[Progress], None] | None, channels: int) -> None:
        self.count, self.seed, self.callback, self.channels = count, seed, callback, channels

    def best(self, run: Callable[..., Result], source: Exemplar) -> Result:
        """The run, told its seed and callback, whose result measures best against the exemplar."""
        if self.count == 1:
            return self._image_of(run(seed=self.seed, callback=self.callback))
        best, least = None, float("inf")
        pictures = [picture[: self.channels] for picture in source.pictures()]
        for number in range(self.count):
            result = self._image_of(run(seed=self.seed + 1000 * number, callback=self._part(number)))
            overall = kwatra.measure(result.image.cpu(), pictures)["overall"]
            if best is None or overall < least:
                best, least = result, overall
        assert best is not None
        return best

    def _image_of(self, result: Result) -> Result:
        """The result without guide channels."""
        stages = [replace(stage, image=stage.image[: self.channels]) for stage in result.stages]
        return replace(result, image=result.image[: self.channels], stages=stages)

    def _part(self, number: int) -> Callable[[Progress], None] | None:
        """The callback for one run, with its fraction as a share of all runs."""
        if self.callback is None:
            return None
        whole = self.callback
        count = self.count
        return lambda p: whole(replace(p, fraction=(number + p.fraction) / count, attempt=number + 1, tries=count))


def _levels(levels: str | Sequence[tuple[int, int]] | None) -> tuple[Level, ...] | None:
    if levels is None:
        return None
    if isinstance(levels, str):
        if levels != "thesis":
            raise InputError(f"levels is {levels!r}; give 'thesis', or pairs of factor and window width")
        return kwatra.THESIS
    return tuple(Level(factor, width) for factor, width in levels)
