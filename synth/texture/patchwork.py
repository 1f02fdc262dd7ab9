"""Several textures in one picture, each where its label is wanted (texture by numbers).

Each is made by itself, so that it is as good as alone: in step with its own lattice, its seams in its own gaps. It is
made a little further than it is wanted, and they are joined along borders that go around elements (`borders`).
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np
import torch
from scipy import ndimage

from kwatra import Exemplar, Progress, Result
from kwatra.pieces import hidden_seams
from kwatra.result import Row
from synth.texture.asked import Asked
from synth.texture.borders import bordered
from synth.texture.form import Form, Image
from synth.texture.labeling import Labels, Rectangle
from synth.texture.runs import share_of
from synth.texture.synthesis import Synthesis
from synth.texture.work import Work

NEAR = 4
"""A border may lie so many pixels from where it is wanted, or an element's size where a texture has gaps. With 8 those
of bricks, rocks, grass and leaves are straight lines where curves are wanted, with 1 as if cut by scissors."""


@dataclass(frozen=True)
class Patchwork(Generic[Image]):
    """Textures to be made where their labels are wanted, of images of one form; weight: what the guide counts."""

    images: list[Image]
    form: Form[Image]
    labels: Labels
    weight: float

    @classmethod
    def of(cls, asked: Asked[Image]) -> "Patchwork[Image] | None":
        """What a guide of stills asks for; None if there is none, or none of labels."""
        if asked.guidance is None:
            return None
        labels = Labels.of(asked.guidance)
        return None if labels is None else cls(asked.images, asked.form, labels, sum(asked.guidance.counts))

    def made(
        self, seed: int, callback: Callable[[Progress], None] | None, tile: bool, **options: Any
    ) -> Synthesis[Image]:
        """The picture; options: those of `synthesize` that say how a texture is made."""
        parts, count = list[_Part](), len(self.labels.textures)
        for number in range(count):
            told = None if callback is None else share_of(callback, number, count)
            parts.append(self._part(number, seed, told, tile, options))
        frames = np.stack([self._framed(part) for part in parts])
        near = [part.near for part in parts]
        shown = bordered(self.labels.wanted, near, frames[:, :-1], frames[:, -1], (tile, tile), self.weight)
        return self._together(parts, frames, shown)

    def _part(
        self, number: int, seed: int, callback: Callable[[Progress], None] | None, tile: bool, options: Any
    ) -> "_Part":
        """A texture by itself, somewhat further than it is wanted; all over the output if that tiles."""
        there, texture = self.labels.wanted == number, self.labels.textures[number]
        crops = [self.images[image][self._index(box)] for image, box in texture]
        alone = hidden_seams(Exemplar.of([self.form.normalized(crop) for crop in crops]))
        reach = NEAR if alone is None else max(round(alone.size), NEAR)
        everywhere = slice(0, there.shape[0]), slice(0, there.shape[1])
        box = everywhere if tile else _around(there, reach + 1)  # borders look at what lies behind them
        asked: Asked[Image] = Asked.of(crops, [side.stop - side.start for side in box])
        work: Work[Image] = Work.of(asked, tile=tile, **options)
        (whole,) = work.stretches()
        made = work.made(work.optimized(whole, None, seed, callback), whole)
        hidden, where = hidden_seams(work.source), tuple(made.result.where.cpu().numpy())
        depth = np.ones(there[box].shape, np.float32) if hidden is None else hidden.depth[where]
        return _Part(box, made, depth, _within(there, reach, tile))

    def _framed(self, part: "_Part") -> np.ndarray:
        """What is made of a texture, and last how deep it is, (C + 1, H, W), 0 where it is not made."""
        image = self.form.converted(part.made.result.image.cpu(), part.made.form)
        frame = np.zeros((len(image) + 1, *part.near.shape), np.float32)
        frame[:, *part.box] = np.concatenate([image.numpy(), part.depth[None]])
        return frame

    def _together(self, parts: Sequence["_Part"], frames: np.ndarray, shown: np.ndarray) -> Synthesis[Image]:
        """What is shown (H, W) of each part as one."""
        image = torch.from_numpy(np.take_along_axis(frames[:, :-1], shown[None, None], 0)[0])
        source, rows, even = np.zeros((3, *shown.shape), np.int64), list[Row](), list[Any]()
        if any(part.made.even for part in parts):
            even = deepcopy(self.images)
        turns = None if parts[0].made.turns is None else np.zeros((2, 2, *shown.shape), parts[0].made.turns.dtype)
        for number, (part, texture) in enumerate(zip(parts, self.labels.textures, strict=True)):
            made, here = part.made, shown == number
            there = here[part.box]
            source[:, here] = _on_images(made.source[:, there], texture)
            if turns is not None and made.turns is not None:
                turns[:, :, here] = made.turns[:, :, there]
            for (at, box), lit in zip(texture, made.even, strict=False):
                even[at][self._index(box)] = lit
            rows += [{"label": number, **row} for row in made.result.energies]
        nowhere, last = torch.empty(0, *shown.shape, dtype=torch.long), parts[-1].made.result
        result = Result(image, torch.from_numpy(source), nowhere, rows, [], last.stopped)
        return Synthesis(self.form.restored(image), source, result, self.form, turns, even)

    def _index(self, box: Rectangle) -> tuple[slice, ...]:
        """That of a rectangle of the user's images."""
        return (slice(None), *box) if self.form.tensor else box


@dataclass(frozen=True)
class _Part:
    """What is made of a texture for a box of the output; depth (h, w): of each of its pixels in its element.

    near (H, W): where in the output it may be shown.
    """

    box: Rectangle
    made: Synthesis[Any]
    depth: np.ndarray
    near: np.ndarray


def _around(there: np.ndarray, reach: int) -> Rectangle:
    """The box of what is there (H, W), and of as much around it."""
    (box,) = ndimage.find_objects(there.astype(np.int8))
    rows, columns = (
        slice(max(side.start - reach, 0), min(side.stop + reach, size))
        for side, size in zip(box, there.shape, strict=True)
    )
    return rows, columns


def _within(there: np.ndarray, reach: int, wraps: bool) -> np.ndarray:
    """Where (H, W) something is so near; wraps: also across the border."""
    around = np.pad(there, reach, mode="wrap" if wraps else "constant")
    near: np.ndarray = ndimage.distance_transform_edt(~around) <= reach
    return near[reach:-reach, reach:-reach]


def _on_images(source: np.ndarray, shown: Sequence[tuple[int, Rectangle]]) -> np.ndarray:
    """Pixels (3, n) of crops, as (number, row, column), as those of the images that they were cut out of."""
    first = np.array([[image, box[0].start, box[1].start] for image, box in shown])[source[0]].T
    return first + source * [[0], [1], [1]]
