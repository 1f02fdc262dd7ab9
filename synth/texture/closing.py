"""A part of an image or video around a hole, closed by copies: in several tries, and with what is done to their seams.

A still is closed by blocks and then improved by EM, whose last iteration also compares gradients (thesis section 5.3):
its blend spreads what is left of a step at the hole's border inwards. Elements between which there is ground come in
one color each in place of that (`synth.texture.evening`). A video is closed by blocks alone, as windows mix what moves:
its seams are feathered where frames tell little of each other (`synth.texture.feathering`), and its light goes on
evenly (`synth.texture.light`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import torch
from scipy.ndimage import distance_transform_edt
from torch import Tensor

import kwatra
from kwatra import Exemplar, Feature, HardPixels, Level, Prepared, Progress, Result, Settings, Stage
from kwatra.loop import Beginning
from kwatra.pieces import GivenCopies, parts_of
from kwatra.scoring import Ranking
from synth.texture.evening import evened
from synth.texture.feathering import feathered, passage
from synth.texture.holes import box_around
from synth.texture.light import evened_inside
from synth.texture.runs import seed_of

GRADIENT = 32.0
"""What gradients count beside colors in the last iteration. Steps across the borders of the same holes are .93 times
what they were; 1.21 times without, .98 with 8, at the same sharpness within a hundredth."""

REACH = 32
"""That iteration is of what lies so near to what is known. Eight pictures continued by 100 pixels score .0506 and step
1.09 times as much across the border as elsewhere, as they do where all is smoothed; one continued by 700 takes 12 s in
place of 32."""


class Closing:
    """The runs that fill a part of an image, of `rest` known pixels, each with its share of the progress."""

    def __init__(
        self,
        source: Prepared,
        rest: HardPixels,
        settings: Settings,
        tries: int,
        callback: Callable[[Progress], None] | None,
    ) -> None:
        self.source, self.rest, self.settings, self.tries, self.callback = source, rest, settings, tries, callback

    def best(self, seed: int, pictures: Sequence[Tensor]) -> Result:
        """The run whose result measures best against pictures of the exemplar; the first where it cannot be told."""
        results = [self.run(number, seed) for number in range(self.tries)]
        if len(results) == 1 or not pictures:
            return results[0]
        figure = Ranking(pictures)
        return min(results, key=lambda result: figure(result.image.cpu()))

    def run(self, number: int, seed: int) -> Result:
        """One filling, its seams smoothed; a periodic picture goes on by itself.

        Where elements are apart they are evened in place of that, and EM is left to finish what was laid coarser: at a
        hole's border, where colors part that are evened later, it puts strips of others.
        """
        shape = self.rest.target.shape[1:]
        beginning = kwatra.begin(self.source, shape, self.settings, self.rest, seed=seed_of(seed, number))
        apart = beginning.gaps is not None and beginning.gaps.hidden.parts is None
        if len(shape) > 2 or (apart and max(beginning.factors) == 1):
            beginning = beginning.as_copied()
        done = apart or beginning.finished or bool(self._missing.all())
        share = 1.0 if done else 0.8
        filled = kwatra.improve(beginning.without_blocks(), callback=self._part(number, 0.0, share))
        if len(shape) > 2:
            return replace(filled, image=self._lit(filled))
        if apart:
            return replace(filled, image=self._evened(beginning, filled))
        return filled if done else self._smoothed(number, share, filled)

    def _smoothed(self, number: int, share: float, filled: Result) -> Result:
        """A still that was filled in a share of the work, with the steps at its seams near what is known spread.

        What lies further from it stays as it is.
        """
        width = min(8, *self._missing.shape, *(level.width for level in self.settings.levels or ()))
        near = self._missing & (torch.from_numpy(distance_transform_edt(self._missing.numpy())) <= REACH)
        box = box_around(near, [width, width])
        inside = (slice(None), *box)
        free = near[box].to(filled.image.device)
        last = replace(self.settings, levels=(Level(1, width, 1),), features=(Feature(kwatra.gradient, GRADIENT),))
        smooth = kwatra.optimize(
            self.source,
            free.shape,
            settings=last,
            terms=HardPixels(filled.image[inside], ~free[None], weight=self.rest.weight),
            start=filled.image[inside],
            callback=self._part(number, share, 1 - share),
        )
        merged = {name: getattr(filled, name).clone() for name in ("image", "source", "where")}
        for name, whole in merged.items():
            whole[inside][:, free] = getattr(smooth, name)[:, free]
        level = len(filled.stages)
        stages = [*filled.stages, Stage(level, 1, width, merged["image"])]
        energies = [*filled.energies, *({**row, "level": level} for row in smooth.energies)]
        return replace(smooth, **merged, energies=energies, stages=stages)

    def _evened(self, beginning: Beginning, filled: Result) -> Tensor:
        """The picture that was filled by copies, elements that are made up of several in one color."""
        copied, owned = self._known
        assert beginning.gaps is not None
        hidden = beginning.gaps.hidden.finer(max(beginning.factors), owned.shape)
        parts = parts_of(hidden, (owned.owner >= 0).numpy())
        image = evened(owned.canvas, parts, filled.where.cpu(), copied, self.rest.target.cpu())
        return image.to(filled.image.device)

    def _lit(self, filled: Result) -> Tensor:
        """The video that was filled by copies: its seams feathered, and its light going on from what is known."""
        copied, owned = self._known
        free, frames = self._missing, torch.ones(copied.shape[1], dtype=torch.bool)
        where, image = torch.where(free, filled.where.cpu(), copied), filled.image.cpu()
        soft = feathered(image, where, owned, passage(self.source.exemplar), (False,) * 3, frames)
        return evened_inside(torch.where(free, soft, image), where, owned, free).to(filled.image.device)

    @cached_property
    def _missing(self) -> Tensor:
        """Which pixels (*S) are not known, on the CPU."""
        return (self.rest.where != 1).all(0).cpu()

    @property
    def _known(self) -> tuple[Tensor, Exemplar]:
        """Where on the exemplar's canvas known pixels lie (n, *S), below 0 for the others; and it, they being of it.

        Both are on the CPU.
        """
        copied = self.rest.copied()
        assert copied is not None  # what is filled goes on from what is known
        return copied.cpu(), GivenCopies(copied.shape[1:], copied).owned(self.source.exemplar).to("cpu")

    def _part(self, number: int, begin: float, share: float) -> Callable[[Progress], None] | None:
        """The callback for a part of the work."""
        if self.callback is None:
            return None
        whole = self.callback
        first, tries = number + begin, self.tries
        return lambda p: whole(
            replace(p, fraction=(first + share * p.fraction) / tries, attempt=number + 1, tries=tries)
        )
