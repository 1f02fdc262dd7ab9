"""Image synthesis: a new picture of any size from pictures of one texture."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

import kwatra
from kwatra import Exemplar, InputError, Level, Progress, Result, Settings, Sum, TermLike

Image = TypeVar("Image", Tensor, np.ndarray)
Map = TypeVar("Map", Tensor, np.ndarray)

PRESETS = {
    "fast": (Settings(iterations=1, candidates=2, exact_pairs=1 << 22), 1),
    "default": (Settings(), 1),
    "best": (Settings(iterations=6), 4),
}
"""Settings, and how many seeds are tried of which the best result is kept."""


@dataclass(frozen=True)
class Synthesis(Generic[Image]):
    """A synthesized picture.

    image: of the same kind as the exemplar. source (3, H, W) int64: for each pixel the number of the image it comes
    from and its row and column there. result: what the engine returned (its image normalized, channels first).
    """

    image: Image
    source: np.ndarray
    result: Result
    form: "_Form[Image]"

    @property
    def stages(self) -> list[Image]:
        """The picture after each level, at that level's resolution, in the exemplar's kind and range."""
        return [self.form.restored(stage.image.cpu()) for stage in self.result.stages]

    def take(self, maps: Map | Sequence[Map]) -> Map:
        """Rearrange a map that belongs to the exemplar (one per image) just as the exemplar's pixels were.

        Arrays are (H, W) or (H, W, C), tensors (C, H, W); values and dtype stay exactly as they are.
        """
        several: list[Map] = [maps] if isinstance(maps, (Tensor, np.ndarray)) else list(maps)
        if len(several) <= self.source[0].max():
            raise InputError(f"{len(several)} maps were given, but the exemplar has more images; give one for each")
        arrays: list[np.ndarray] = [m.movedim(0, -1).numpy() if isinstance(m, Tensor) else m for m in several]
        taken = np.empty((*self.source.shape[1:], *arrays[0].shape[2:]), arrays[0].dtype)
        for number, array in enumerate(arrays):
            here = self.source[0] == number
            taken[here] = array[self.source[1][here], self.source[2][here]]
        rearranged: Any = torch.from_numpy(taken).movedim(-1, 0) if isinstance(several[0], Tensor) else taken
        return rearranged  # the kind of maps that were given


def synthesize(
    exemplar: Image | Sequence[Image],
    size: tuple[int, int],
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
    is 1. Same seed, same bits, for any number of threads. Raises InputError for what cannot be used.
    """
    images = [exemplar] if isinstance(exemplar, (Tensor, np.ndarray)) else list(exemplar)
    if not images:
        raise InputError("no exemplar was given; give at least one image")
    form = _Form.of(images)
    if preset not in PRESETS:
        raise InputError(f"the preset is {preset!r}; allowed are {', '.join(PRESETS)}")
    settings, tries = PRESETS[preset]
    settings = replace(settings, wrap=tile, levels=_levels(levels))
    source = Exemplar.of(
        [form.normalized(image) for image in images], mirror=mirror, rotate=rotate, scale=scale, device=device
    )
    begin = None if start is None else form.normalized(start).to(device)
    runs = _Runs(tries, callback)
    result = runs.best(
        lambda number, call: kwatra.optimize(
            source, size, settings=settings, terms=terms, start=begin, seed=seed + 1000 * number, callback=call
        ),
        source,
    )
    return Synthesis(form.restored(result.image.cpu()), result.source.cpu().numpy(), result, form)


class _Runs:
    """Several runs of which the best is kept."""

    def __init__(self, count: int, callback: Callable[[Progress], None] | None) -> None:
        self.count, self.callback = count, callback

    def best(self, run: Callable[[int, Callable[[Progress], None] | None], Result], source: Exemplar) -> Result:
        """The run whose result measures best against the exemplar."""
        if self.count == 1:
            return run(0, self.callback)
        best, least = None, float("inf")
        for number in range(self.count):
            result = run(number, self._part(number))
            overall = kwatra.measure(result.image.cpu(), source.pictures())["overall"]
            if best is None or overall < least:
                best, least = result, overall
        assert best is not None
        return best

    def _part(self, number: int) -> Callable[[Progress], None] | None:
        """The callback for one run, with its fraction as a share of all runs."""
        if self.callback is None:
            return None
        whole = self.callback
        return lambda p: whole(replace(p, fraction=(number + p.fraction) / self.count))


@dataclass(frozen=True)
class _Form(Generic[Image]):
    """The kind of image the user gave, and the affine map of its values to [0, 1]."""

    tensor: bool
    flat: bool
    dtype: torch.dtype | np.dtype
    low: float
    high: float

    @classmethod
    def of(cls, images: Sequence[Image]) -> "_Form[Image]":
        first = images[0]
        low, high = float("inf"), float("-inf")
        for image in images:
            wanted = (3,) if isinstance(image, Tensor) else (2, 3)
            if type(image) is not type(first) or image.ndim not in wanted or 0 in image.shape:
                raise InputError(
                    f"an exemplar is a {type(image).__name__} of shape {tuple(image.shape)}; give tensors (C, H, W), "
                    "or arrays (H, W) or (H, W, C), all of one kind and not empty"
                )
            values = torch.as_tensor(image).double()
            if not bool(values.isfinite().all()):
                raise InputError("an exemplar holds NaN or infinite pixels; replace them first")
            low, high = min(low, float(values.min())), max(high, float(values.max()))
        return cls(isinstance(first, Tensor), first.ndim == 2, first.dtype, low, high)

    def normalized(self, image: Image) -> Tensor:
        """As a float tensor (C, H, W) with values in [0, 1]."""
        values = torch.as_tensor(np.ascontiguousarray(image) if isinstance(image, np.ndarray) else image).double()
        if not self.tensor:
            values = values[None] if self.flat else values.permute(2, 0, 1)
        return ((values - self.low) / ((self.high - self.low) or 1.0)).float().contiguous()

    def restored(self, image: Tensor) -> Image:
        """The inverse of `normalized`, in the user's kind and dtype."""
        values: Any = (image.double() * (self.high - self.low) + self.low).clamp(self.low, self.high)
        if isinstance(self.dtype, torch.dtype):
            return (values if self.dtype.is_floating_point else values.round()).to(self.dtype)
        values = (values[0] if self.flat else values.permute(1, 2, 0)).numpy()
        return (values if np.issubdtype(self.dtype, np.floating) else values.round()).astype(self.dtype)


def _levels(levels: str | Sequence[tuple[int, int]] | None) -> tuple[Level, ...] | None:
    if levels is None:
        return None
    if isinstance(levels, str):
        if levels != "thesis":
            raise InputError(f"levels is {levels!r}; give 'thesis', or pairs of factor and window width")
        return kwatra.THESIS
    return tuple(Level(factor, width) for factor, width in levels)
