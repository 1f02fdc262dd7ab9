"""Cross-dissolve: every pixel goes straight from A's color to B's; in between both textures show at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from synth.metamorphosis.method import Film, Frames, Method, Pair, Report


@dataclass(frozen=True)
class Blend(Method):
    """(1 - t) A + t B."""

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """See `synth.metamorphosis.method.Method`."""
        shown = (torch.lerp(pair.a, pair.b, time) for time in times)
        return Film(Frames(shown, len(times)), tuple(times))


PRESETS = dict.fromkeys(("fast", "default", "best"), Blend())
