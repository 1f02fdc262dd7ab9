"""Metamorphosis by patches (Ruiters, Schnabel and Klein, Patch-based Texture Interpolation, 2010) as a film.

The paper makes each image from noise. Here each frame is what the frame before it becomes when its patches are shown at
the next time, where they lie, and then a texture again: so elements grow, turn and change their shape, and stay.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from torch import Tensor

from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.patches.interpolation import PUBLISHED, Frame, Interpolation, Pyramid
from synth.metamorphosis.patches.model import Making
from synth.metamorphosis.patches.pace import Pace
from synth.metamorphosis.patches.synthesis import Synthesis
from synth.metamorphosis.patches.weighting import Weighting

CARRYING = Synthesis(rejected=0.0, iterations=2, relaxed=False, mean_shift=False)
"""On three pairs mean shift made films restless and rejection lost what B has; relaxing changed little."""


@dataclass(frozen=True)
class PatchMorph(Method):
    """How to morph by patches; a `Method`.

    making: how neighborhoods in between are made. synthesis: how a frame is made of them by itself, on the levels of
    `pyramid`; carrying: how, on the last of them, if it is what the one before becomes. statistics: detail that
    blends take away is given back (section 4.5). even: a frame is as far on its way, by measure, as
    its time says; or else the time is the share of B in its neighborhoods. independent: every frame is made by itself,
    as published. size: (height, width) of frames, by default that of A.
    """

    making: Making = field(default_factory=Making)
    synthesis: Synthesis = field(default_factory=Synthesis)
    carrying: Synthesis = CARRYING
    pyramid: Pyramid = PUBLISHED
    statistics: bool = True
    even: bool = True
    independent: bool = False
    size: tuple[int, int] | None = None

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair; InputError for textures smaller than the windows, and maps that are empty or full."""
        features = None if pair.features_a is None or pair.features_b is None else (pair.features_a, pair.features_b)
        shape = self.size or (pair.a.shape[1], pair.a.shape[2])
        between = self.between((pair.a, pair.b), features, shape, pair.tile, seed)
        report("matching patches", 0.0)
        weightings = [Weighting.even((1 - time, time), shape) for time in times]
        if self.even:
            pace = Pace.of(between.finest, between.bands)
            weightings = [weighting.paced(pace) for weighting in weightings]
        frames = filmed(between, weightings, report, self.independent)
        remarks = (between.found.remark,)
        return Film(
            Frames((frame.image for frame in frames), len(times)),
            tuple(times),
            remarks=remarks,
            features=between.found.maps,
        )

    def between(
        self,
        images: tuple[Tensor, ...],
        features: tuple[Tensor, ...] | None,
        shape: tuple[int, int],
        tile: bool,
        seed: int,
        weightings: int = 1,
    ) -> Interpolation:
        """Textures made ready, with these settings; see `Interpolation`."""
        return Interpolation(
            images,
            features,
            shape,
            tile,
            self.making,
            self.synthesis,
            self.carrying,
            self.pyramid,
            seed,
            self.statistics,
            weightings,
        )

    def of_size(self, size: tuple[int, int]) -> "PatchMorph":
        """Frames have any size (height, width) by themselves."""
        return replace(self, size=size)


def filmed(
    between: Interpolation, weightings: Sequence[Weighting], report: Report, independent: bool = False
) -> Iterator[Frame]:
    """Frames of weightings, each what the one before becomes; independent: each by itself."""
    frame: Frame | None = None
    for number, weighting in enumerate(weightings):
        report(f"frame {number + 1} of {len(weightings)}", number / len(weightings))
        frame = between.still(weighting) if frame is None or independent else between.onward(frame, weighting)
        yield frame
    report("done", 1.0)


PRESETS = {
    "fast": PatchMorph(Making(anchors=600), Synthesis(iterations=2, mean_shift=False), pyramid=((2, 17), (1, 17))),
    "default": PatchMorph(),
    "best": PatchMorph(synthesis=Synthesis(iterations=5)),
}
