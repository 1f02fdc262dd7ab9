"""Long videos in stretches: each holds the last frames of the one before it, as hard pixels.

So the memory is that of one stretch, however long the video. What is held are frames as they are shown, in the
exemplar's own depth: a stretch follows from its own number and those frames, and is the same bits in a later run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra import HardPixels
from kwatra.base import even_ranges
from synth.texture.form import Form

VOXELS = 1 << 22
"""Pixels of a stretch: an optimization takes about 300 bytes for each."""

HELD = 8
"""Frames that a stretch holds of the one before it: twice a window's depth."""


@dataclass(frozen=True)
class Stretch:
    """Frames first to stop - 1 of a video, with `before` and `after` frames held around them; number: from 0."""

    number: int
    first: int
    stop: int
    before: int = 0
    after: int = 0

    @classmethod
    def whole(cls, length: int) -> "Stretch":
        """All of a picture or video."""
        return cls(0, 0, length)

    @property
    def length(self) -> int:
        """Frames to optimize."""
        return self.before + self.stop - self.first + self.after

    def behind(self, done: int) -> "Stretch":
        """The same stretch where only the frames from `done` on are new."""
        more = max(done - self.first, 0)
        return replace(self, first=self.first + more, before=self.before + more)

    def seed(self, seed: int) -> int:
        """A seed of its own, the given one for the first stretch."""
        return seed if self.number == 0 else (seed << 32) + self.number

    def held(self, memory: "Memory", form: Form[Any], device: torch.device) -> Tensor | None:
        """The frames it holds, (C, before + after, H, W) in [0, 1]; None where it holds none."""
        if not self.before and not self.after:
            return None
        spans = [(self.first - self.before, self.first)] * (self.before > 0) + [(0, self.after)] * (self.after > 0)
        return torch.cat([form.normalized(memory.frames(*span)) for span in spans], 1).to(device)

    def holding(self, held: Tensor, shape: Sequence[int]) -> HardPixels:
        """The term that holds them in a video of (length, height, width)."""
        target = torch.zeros(len(held), *shape, dtype=torch.float32, device=held.device)
        where = torch.zeros(1, *shape, dtype=torch.bool, device=held.device)
        if self.before:
            target[:, : self.before], where[:, : self.before] = held[:, : self.before], True
        if self.after:
            target[:, -self.after :], where[:, -self.after :] = held[:, self.before :], True
        return HardPixels(target, where, weight=0.0, label="held frames")


class Memory:
    """Frames that stretches to come will hold, the first and the last ones; or what `shown` gives, if it is there."""

    def __init__(self, shown: Callable[[int, int], Any] | None = None) -> None:
        self.shown = shown
        self.parts: dict[tuple[int, int], Any] = {}

    def keep(self, part: Stretch, image: Any, tensor: bool) -> None:
        """Remember what of a stretch's frames, (C, T, H, W) or (T, H, W, C), others may hold."""
        if self.shown is not None:
            return
        count = part.stop - part.first
        for low, high in {(0, min(HELD, count)), (max(count - HELD, 0), count)}:
            frames = image[:, low:high] if tensor else image[low:high]
            self.parts[part.first + low, part.first + high] = frames.clone() if tensor else np.copy(frames)
        for span in [span for span in self.parts if span[0] != 0 and span[1] < part.first]:
            del self.parts[span]

    def frames(self, first: int, stop: int) -> Any:
        """The frames from first to stop - 1."""
        return self.parts[first, stop] if self.shown is None else self.shown(first, stop)


def planned_stretches(size: Sequence[int], loop: bool) -> list[Stretch]:
    """The stretches of a video of size (frames, height, width), all about as long."""
    frames, area = size[0], size[1] * size[2]
    most = max(VOXELS // area, 4 * HELD)
    if frames <= most:
        return [Stretch.whole(frames)]
    count = -(-frames // (most - HELD))
    return [
        Stretch(number, first, stop, HELD if number else 0, HELD if loop and number == count - 1 else 0)
        for number, (first, stop) in enumerate(even_ranges(frames, count))
    ]
