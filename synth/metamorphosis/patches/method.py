"""Metamorphosis by patches (Ruiters, Schnabel and Klein, Patch-based Texture Interpolation, 2010) as a film.

The paper makes each image by itself; so do `independent`, a still whose weights are the same everywhere, and one mostly
in between textures whose elements differ in size. Else each frame is a texture like what `Passage` shows at its time,
so a film begins in A, ends in B, what moves does so smoothly, and where a map gives a texture all the weight it is as
good as that texture synthesized. Where A and B cancel each other there (dark lines on light lines), the first frame is
made as published, and each other is what the one before becomes when its patches are shown at their next weights, where
they lie: such a film ends as a texture of B.

Where elements of A and B differ in size, both are led at a common scale, and frames zoom in or out about their middle:
elements grow or shrink from frame to frame. Of the texture whose elements are larger more is seen then than its
exemplar shows, so it is continued.

Stills that were led showed both textures where one could not be brought onto the other. Of five pairs of photographs,
256x256 from 128x128 px, they were sharper nowhere, and halfway more of their structure was in neither texture: .112,
.086 and .028 of stones, pebbles and bricks, which made by themselves have .084, .052 and 0.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from kwatra.base import InputError
from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.pairing import Growth
from synth.metamorphosis.patches.interpolation import PUBLISHED, Frame, Interpolation, Pyramid
from synth.metamorphosis.patches.model import Making
from synth.metamorphosis.patches.pace import Pace
from synth.metamorphosis.patches.passage import Passage
from synth.metamorphosis.patches.surroundings import surrounded
from synth.metamorphosis.patches.synthesis import Synthesis
from synth.metamorphosis.patches.weighting import Weighting
from synth.metamorphosis.velocity import PRESETS as SEARCHES

CARRYING = Synthesis(rejected=0.0, iterations=2, relaxed=False, mean_shift=False)
"""On three pairs mean shift made films restless and rejection lost what B has; relaxing changed little."""

FOLLOWING = replace(CARRYING, free_centers=False)
"""Beside a wish free centers gain nothing."""

_JUMP = 0.25
"""A weight that changes so much from a pixel to the next jumps. Not tuned: maps looked at changed by .02, or by 1."""

CANCELING = "the textures cancel each other where they lie, so frames are made from patches alone and end as a texture"


@dataclass(frozen=True)
class PatchMorph(Method):
    """How to morph by patches; a `Method`.

    making: how neighborhoods in between are made. synthesis: how a frame is made of them as published, on the levels of
    `pyramid`; following: how, on the last of them, if it is like what a passage shows; carrying: how, if it is what the
    one before becomes. statistics: detail that blends take away is given back (section 4.5). even: a frame not led
    by its time is as far on its way, by measure, as its time says; or else the time is the share of B in its
    neighborhoods. independent: every frame is made by itself, as published. search: how thoroughly A is brought
    onto B in a film, and textures are synthesized where frames have another size: "fast", "default" or "best".
    size: (height, width) of frames, by default that of A.
    """

    making: Making = field(default_factory=Making)
    synthesis: Synthesis = field(default_factory=Synthesis)
    carrying: Synthesis = CARRYING
    following: Synthesis = FOLLOWING
    pyramid: Pyramid = PUBLISHED
    statistics: bool = True
    even: bool = True
    independent: bool = False
    search: str = "default"
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.search not in SEARCHES:
            raise InputError(f"the search is {self.search!r}; allowed are {', '.join(SEARCHES)}")

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair; InputError for textures smaller than the windows, and maps that are empty or full."""
        shape = self.size or (pair.a.shape[1], pair.a.shape[2])
        between = self.between((pair.a, pair.b), _features(pair), shape, pair.tile, seed)
        report("matching patches", 0.0)
        passage = None if len(times) == 1 or self.independent else self._passage(between, pair, seed, report)
        if passage is None or passage.cancels:
            weightings = (Weighting.even((1 - time, time), shape) for time in times)
            made: Iterator[Tensor] = (frame.image for frame in self.frames(between, weightings, len(times), report))
            remarks = self.remarks(between, len(times))
        else:
            made = _passing(between, passage, times, report)
            remarks = (between.found.remark,)
        return Film(Frames(made, len(times)), tuple(times), remarks=remarks, features=between.found.maps)

    def frames(
        self,
        between: Interpolation,
        weightings: Iterable[Weighting],
        count: int,
        report: Report,
    ) -> Iterator[Frame]:
        """A frame for each of `count` weightings, one by one; the frame before, where weightings are the same.

        Each is like what the passage shows. Where textures cancel each other there the first is made as published, and
        others are what the one before becomes; if independent, all are made as published.
        """
        pace = Pace.of(between.finest, between.bands) if self.even and len(between.images) == 2 else None
        frame: Frame | None = None
        for number, weighting in enumerate(weightings):
            report(f"frame {number + 1} of {count}", number / count)
            paced = weighting if pace is None else weighting.paced(pace)
            if frame is None or self.independent:
                frame = self._begun(between, paced, count == 1)
            elif not torch.equal(frame.weighting.values, paced.values):
                led = frame.arrangement is None
                frame = between.led(paced, frame) if led else between.carried(frame, paced)
            yield frame
        report("done", 1.0)

    def _begun(self, between: Interpolation, weighting: Weighting, still: bool) -> Frame:
        """A frame that is made by itself, or the first of a film."""
        if self.independent or (still and _unled(between, weighting)) or between.passage.cancels:
            return between.published(weighting)
        return between.led(weighting)

    def remarks(self, between: Interpolation, count: int) -> tuple[str, ...]:
        """Sentences for a person on how `count` frames are made."""
        carried = count > 1 and not self.independent and between.passage.cancels
        return (between.found.remark, *((CANCELING,) if carried else ()))

    def _passage(self, between: Interpolation, pair: Pair, seed: int, report: Report) -> Passage:
        """What leads from A to B, both synthesized first if frames have another size."""
        maps = between.found.maps
        if between.shape != tuple(pair.a.shape[1:]):
            pair = Growth(self.search, seed, "cpu")(pair, between.shape, report)
            maps = replace(between, images=(pair.a, pair.b), features=_features(pair)).found.maps
        units = (1.0, 1.0) if pair.tile else between.units
        given = zip((pair.a, pair.b), maps, units, strict=True)
        grown = [surrounded(image, own, unit / min(units), self.search, seed) for image, own, unit in given]
        images, maps = zip(*grown, strict=True)
        width, search = self.pyramid[-1][1], SEARCHES[self.search]
        return Passage.of(images, maps, width, self.making, search, pair.tile, report, units=units)

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
            self.following,
            self.pyramid,
            seed,
            self.statistics,
            SEARCHES["fast" if self.search == "default" else self.search],
            self.search,
            weightings,
        )

    def of_size(self, size: tuple[int, int]) -> "PatchMorph":
        """Frames have any size (height, width) by themselves."""
        return replace(self, size=size)


def _unled(between: Interpolation, weighting: Weighting) -> bool:
    """Whether a still is better made as published than led: one whose weights are the same everywhere, or a map.

    A map, if most of it lies in between and it does not jump: led, elements of both textures show where one cannot be
    brought onto the other. Looked at on strips between five pairs of photographs and on two triangles. Where a map
    jumps specks show if it is not led; but led, rows of different height lie over each other. Where textures are alone
    what each has for itself is better led.
    """
    if len(weighting.palette) == 1:
        return True
    mixed = float((weighting.values.amax(0) < 1).float().mean()) > 0.5
    return mixed and (weighting.steepest < _JUMP or len(set(between.units)) > 1)


def _passing(between: Interpolation, passage: Passage, times: Sequence[float], report: Report) -> Iterator[Tensor]:
    """The frames at some times."""
    ends = dict(zip((0.0, 1.0), passage.pictures, strict=True))
    for number, time in enumerate(times):
        report(f"frame {number + 1} of {len(times)}", number / len(times))
        yield ends[time] if time in ends else between.along(passage, time)
    report("done", 1.0)


def _features(pair: Pair) -> tuple[Tensor, Tensor] | None:
    return None if pair.features_a is None or pair.features_b is None else (pair.features_a, pair.features_b)


PRESETS = {
    "fast": PatchMorph(
        Making(anchors=600, cells=2, points=20),
        Synthesis(iterations=2, relaxed=False),
        following=replace(FOLLOWING, iterations=1),
        pyramid=((2, 17), (1, 17)),
        search="fast",
    ),
    "default": PatchMorph(),
    "best": PatchMorph(synthesis=Synthesis(iterations=5), search="best"),
}
