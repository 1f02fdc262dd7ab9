"""Metamorphosis by patterns (Liu, Liu, Shum and Yu, Pattern-Based Texture Metamorphosis, 2002).

Each texture is an arrangement of one pattern. Landmarks in order say how a pattern of A becomes one of B, an
assignment says which becomes which, and a warp through all landmarks carries everything else along.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import InputError
from synth.metamorphosis.bands import dissolved
from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.patterns.correspondence import Correspondence, corresponding
from synth.metamorphosis.patterns.film import Warping, crowding, median, phases, touching, within
from synth.metamorphosis.patterns.finding import Found, patterns_of
from synth.metamorphosis.patterns.landmarks import Patterns
from synth.metamorphosis.patterns.outlines import alike

_Landmarks = Callable[[float], Tensor]


@dataclass(frozen=True)
class PatternMorph(Method):
    """How to morph by patterns; a `Method`.

    patterns_a, patterns_b: landmarks, or all patterns, of each texture; None finds elements. threshold: distance up to
    which a pattern is taken for that of the landmarks; None finds it. scale_elements: elements are scaled by this,
    in (0, 1], while they move; None makes them as small as keeps them apart, and 1 moves them as they are.
    median: odd number of frames over which pixels' medians are taken, 1 for none. warping, dissolving: from when to
    when, in times of 0 to 1, shapes and colors change.

    It suits textures of distinct elements. Frames have the size that both exemplars have in common, from the top left.
    """

    patterns_a: Patterns | None = None
    patterns_b: Patterns | None = None
    threshold: float | None = None
    scale_elements: float | None = None
    median: int = 1
    warping: tuple[float, float] = (0.0, 1.0)
    dissolving: tuple[float, float] = (0.0, 1.0)

    def __post_init__(self) -> None:
        if self.median < 1 or self.median % 2 == 0:
            raise InputError(f"the median is over {self.median} frames; give an odd number, 1 for none")
        if self.scale_elements is not None and not 0 < self.scale_elements <= 1:
            raise InputError(f"elements are scaled by {self.scale_elements}; give a number above 0 and up to 1")
        for begin, end in (self.warping, self.dissolving):
            if not 0 <= begin < end <= 1:
                raise InputError(f"a transition goes from {begin} to {end}; give two times in order within 0 and 1")
        a, b = self.patterns_a, self.patterns_b
        if a is not None and b is not None and not (a.closed or b.closed) and len(a.landmarks) != len(b.landmarks):
            raise InputError(
                f"the patterns have {len(a.landmarks)} landmarks in A and {len(b.landmarks)} in B; give equally many"
            )

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair; nothing in it is random.

        Raises InputError if fewer than 4 patterns are found in a texture, or they are hardly distinct.
        """
        a, b = (image[:, : pair.b.shape[1], : pair.b.shape[2]] for image in (pair.a, pair.b))
        b = b[:, : a.shape[1], : a.shape[2]]
        size = (a.shape[1], a.shape[2])
        ways, remarks = self._ways(pair, size, report)
        scale = crowding(ways) if self.scale_elements is None else self.scale_elements
        warping = Warping(pair.tile, touching(ways))

        def landmarks(t: float) -> Tensor:
            moved, smaller = phases(within(t, self.warping), scale)
            return torch.from_numpy(ways.at(moved, smaller).reshape(-1, 2))

        def frames() -> Iterator[Tensor]:
            for number, t in enumerate(times):
                report("warping", 0.2 + 0.8 * number / len(times))
                now = landmarks(t)
                from_a, from_b = warping.moved(a, landmarks(0), now), warping.moved(b, landmarks(1), now)
                yield dissolved(from_a, from_b, within(t, self.dissolving), pair)

        if self.scale_elements is None and scale < 1:
            remarks += (f"elements are crowded: they are scaled by {scale:.2f} while they move",)

        def motion() -> Tensor:
            return _velocity(landmarks, max(1, len(times) - 1), size, warping)

        shown = frames() if self.median == 1 else median(list(frames()), self.median)
        return Film(Frames(shown, len(times)), tuple(times), motion, remarks=remarks)

    def _ways(self, pair: Pair, size: tuple[int, int], report: Report) -> tuple[Correspondence, tuple[str, ...]]:
        """Which pattern becomes which, in a frame of (height, width), and what was found."""
        sets: list[Found] = []
        for name, image, given in (("A", pair.a, self.patterns_a), ("B", pair.b, self.patterns_b)):
            report(f"finding patterns in {name}", 0.1 * len(sets))
            sets.append(patterns_of(image.permute(1, 2, 0).double().numpy(), given, self.threshold, name))
        a, b = (
            each[(each.mean(1) <= [size[1] - 1, size[0] - 1]).all(1)]
            for each in alike(sets[0].every, sets[1].every, sets[0].patterns.closed, sets[1].patterns.closed)
        )
        if not (len(a) and len(b)):
            raise InputError("no pattern lies in the part that A and B have in common; crop them to one size")
        ways = corresponding(a, b, size, sets[0].patterns.closed or sets[1].patterns.closed)
        found = tuple(f"{name}: {each.remark}" for name, each in zip("AB", sets, strict=True))
        alone = len(ways.in_a) - ways.pairs
        grown = f", {alone} {'grow from' if len(b) > len(a) else 'shrink to'} nothing" if alone else ""
        return ways, (*found, f"{ways.pairs} patterns are paired{grown}")


def _velocity(landmarks: _Landmarks, steps: int, size: tuple[int, int], warping: Warping) -> Tensor:
    """The motion (N, 2, H, W) from each of N steps to the next, through the landmarks."""
    points = [landmarks(k / steps) for k in range(steps + 1)]
    return torch.stack([warping.displacement(points[k], points[k + 1], size) for k in range(steps)])


PRESETS = dict.fromkeys(("fast", "default", "best"), PatternMorph())
"""The same for all: it takes a second a frame."""
