"""Metamorphosis under texton masks (Tonietto and Walter, Texture Metamorphosis Driven by Texton Masks, 2005).

A mask says where the elements of a texture are. The masks' own metamorphosis comes first; every frame is then texture
of A under its mask, mixed with texture of B under the same mask. So elements of A lie over elements of B.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError
from synth.metamorphosis.bands import dissolved
from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.textons.guided import guided
from synth.metamorphosis.textons.masks import Color, Mask, checked, colored, found
from synth.metamorphosis.textons.moving import MovingMasks


@dataclass(frozen=True)
class TextonMorph(Method):
    """How to morph under texton masks; a `Method`.

    mask_a, mask_b: booleans (H, W), True in elements. colors_a, colors_b: foreground and background of each texture, as
    the images have them, instead; tolerance: how much nearer to the background what is foreground may be. Without
    either the elements are found. published: pixel by pixel as in the paper, with windows of width window_a in A and
    window_b in B, and frames of `size` (height, width), by default those of A; it takes minutes.
    """

    mask_a: Mask | None = None
    mask_b: Mask | None = None
    colors_a: tuple[Color, Color] | None = None
    colors_b: tuple[Color, Color] | None = None
    tolerance: float = 0.0
    published: bool = False
    window_a: int = 11
    window_b: int = 17
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name, width in (("window_a", self.window_a), ("window_b", self.window_b)):
            if width < 3 or width % 2 == 0:
                raise InputError(f"{name} is {width}; give an odd width of at least 3")
        if not 0 <= self.tolerance < float("inf"):
            raise InputError(f"tolerance is {self.tolerance}; it is a distance of colors, 0 or more")
        if self.size is not None and (len(self.size) != 2 or min(self.size) < 1 or not self.published):
            raise InputError(f"size is {self.size}; give a height and a width above 0, for published frames only")

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair; InputError for masks that part nothing, or windows larger than an exemplar."""
        if self.published:
            self._check_windows(pair)
        masks = self.masks(pair)
        parts = ", ".join(f"{name} is {mask.mean():.0%} elements" for name, mask in zip("AB", masks, strict=True))
        make = self._published if self.published else self._engine
        shown = torch.from_numpy(masks[0]), torch.from_numpy(masks[1])
        frames = Frames(make(pair, masks, times, seed, report), len(times))
        return Film(frames, tuple(times), remarks=(parts,), masks=shown)

    def of_size(self, size: tuple[int, int]) -> "TextonMorph | None":
        """Published frames have any size (height, width) by themselves."""
        return replace(self, size=size) if self.published else None

    def masks(self, pair: Pair) -> tuple[Mask, Mask]:
        """The masks (H, W) of A and B that are used, cleaned."""
        given = (("A", pair.a, self.mask_a, self.colors_a), ("B", pair.b, self.mask_b, self.colors_b))
        a, b = (
            checked(self._mask(image, mask, colors, pair.extremes), image, name) for name, image, mask, colors in given
        )
        return a, b

    def _mask(
        self, image: Tensor, mask: Mask | None, colors: tuple[Color, Color] | None, extremes: tuple[float, float]
    ) -> Mask:
        if mask is not None:
            return np.asarray(mask)
        if colors is None:
            return found(image)
        low, high = extremes
        return colored(low + (high - low) * image, *colors, self.tolerance)

    def _engine(
        self, pair: Pair, masks: tuple[Mask, Mask], times: Sequence[float], seed: int, report: Report
    ) -> Iterator[Tensor]:
        """Texture of B from its own mask back, then of A from its own on, mixed with B's as soon as it is there."""
        height, width = (min(pair.a.shape[axis], pair.b.shape[axis]) for axis in (1, 2))
        (a, mask_a), (b, mask_b) = (
            (image[:, :height, :width].contiguous(), mask[:height, :width])
            for image, mask in zip((pair.a, pair.b), masks, strict=True)
        )
        moving = MovingMasks.of(mask_a, mask_b)
        back, there = sorted({1.0, *times}, reverse=True), sorted({0.0, *times})
        from_b = {}
        for t, frame in zip(back, guided(b, mask_b, moving, back, seed), strict=True):
            from_b[t] = frame
            report("texture of B", len(from_b) / len(back) / 2)
        for number, (t, frame) in enumerate(zip(there, guided(a, mask_a, moving, there, seed), strict=True), 1):
            report("texture of A", (1 + number / len(there)) / 2)
            if t in from_b:
                yield from [dissolved(frame, from_b[t], t, pair)] * times.count(t)

    def _published(
        self, pair: Pair, masks: tuple[Mask, Mask], times: Sequence[float], seed: int, report: Report
    ) -> Iterator[Tensor]:
        """Frames grown pixel by pixel, each over the one before."""
        from synth.metamorphosis.textons.raster import grown

        a, b = (np.ascontiguousarray(image.permute(1, 2, 0).numpy()) for image in (pair.a, pair.b))
        shape = self.size or (a.shape[0], a.shape[1])
        widths = (self.window_a, self.window_b)
        values = (masks[0].astype(np.float32), masks[1].astype(np.float32))
        for number, (frame, _) in enumerate(grown((a, b), values, widths, shape, times, seed), 1):
            report("growing", number / len(times))
            yield torch.from_numpy(frame).permute(2, 0, 1).contiguous()

    def _check_windows(self, pair: Pair) -> None:
        for name, image, width in (("A", pair.a, self.window_a), ("B", pair.b, self.window_b)):
            if width > min(image.shape[1:]):
                raise InputError(
                    f"the window of {name} is {width} wide but {name} {image.shape[2]}x{image.shape[1]}; "
                    "give a smaller one"
                )


PRESETS = dict.fromkeys(("fast", "default", "best"), TextonMorph())
