"""Stills that nothing steers: several beginnings are tried, and parts of the best laid anew, before it is optimized.

What a part is replaced by counts for itself: those few are kept with which the whole is better, and gains add up, where
of whole tries one has to be better everywhere. But parts go on as what lies around them has it: what is wrong with the
whole, as rows that do not meet, only another try mends. Tries then differ much.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from threading import Lock
from typing import NamedTuple

import numpy as np
import torch

from kwatra import Beginning, Exemplar, Progress, Result, Settings, improve
from kwatra.base import apart, generator_of
from kwatra.pieces import Box, visible_seams
from kwatra.scoring import Ranking, pasted
from synth.texture.runs import BESIDE, MANY

TORN, LEAST_TORN = 0.01, 1e-4
"""How many times the logarithm of what seams show counts beside the figure that tries are ranked by, and what is added
to it first. Figures are blind to what is torn, and like it: a tartan shows more of its exemplar then. 22 textures score
.0486 in place of .0484, and of 20 tries of a tartan a whole one is kept in place of a torn one."""

PASTED = 0.03
"""What the mean size of copies counts, as a part of the exemplar: figures like what is pasted as a whole.

The best of 24 of a panel of 16 textures copy .285, .251, .246, .238 and .235 of their exemplar at a time with 0, .02,
.03, .04 and .05, and score .0470, .0479, .0479, .0479 and .0482; those of another, with .03, .231 and .0476."""

PARTS = 2
"""So many parts are laid anew, each of what was best before, for a further try that is not made: both cost as much."""

LEAST, MOST = 0.25, 0.5
"""A part has between so much and so much of the output's height, and of its width; less of that at its border. Of seven
textures .15 to .35 and .4 to .8 gain a seventh less at the same cost."""

ALIKE = 0.0065
"""Figures of first tries whose standard deviation is less are alike: parts then gain more than further tries.

Of 15 textures of one panel three are alike so, and score .0576 with ten tries and 22 parts, .0588 with 24 tries, which
cost as much; the others .0482 and .0466 (two seeds)."""


@dataclass(frozen=True)
class Effort:
    """How many whole beginnings are tried at first, and how many more, or else PARTS parts of the best for each."""

    first: int
    more: int

    @property
    def tries(self) -> int:
        """How many tries there are, PARTS parts being one."""
        return self.first + self.more


class Ranked(NamedTuple):
    """A beginning, its figure, lower is better, and its number among all that are tried."""

    figure: float
    number: int
    beginning: Beginning


class Search:
    """Looks for what best begins an output of a `size` (H, W) that resembles a source, and makes it.

    ways: the settings of first tries, in turn; what follows has those of the best. callback: told after each try, from
    one thread at a time, not always the same, and then of the rest.
    """

    def __init__(
        self,
        effort: Effort,
        ways: Sequence[Settings],
        size: Sequence[int],
        seed: int,
        callback: Callable[[Progress], None] | None,
        source: Exemplar,
    ) -> None:
        self.effort, self.ways, self.size, self.seed = effort, ways, tuple(size), seed
        self.callback, self.source = callback, source
        pictures = source.pictures()
        self._ranking = Ranking(pictures, thorough=effort.tries >= MANY)
        self._channels, self._area = len(pictures[0]), sum(picture[0].numel() for picture in pictures)
        self._figures, self._done, self._telling = dict[int, float](), 0, Lock()

    def best(self, begin: Callable[..., Beginning]) -> Result:
        """What is made of the best beginning; each is told its settings and seed.

        Memory is that of as many beginnings as are tried together.
        """
        first, tries = self.effort.first, self.effort.tries

        def begun(number: int, settings: Settings | None = None) -> Beginning:
            if number == 1:  # meanwhile the first looks at the texture
                self._ranking.describe((self._channels, *self.size))
            way = self.ways[number % len(self.ways)] if settings is None else settings
            return begin(settings=way, seed=self._seed(number))

        if tries == 1:
            return improve(begun(0), callback=self.callback)
        best = self._best_of(begun, range(first), None)
        if best.beginning.blocks is None:  # exactly periodic, so that all are the same
            pass
        elif self._spread() < ALIKE:
            for number in range(first, first + PARTS * self.effort.more, PARTS):
                best = self._best_of(partial(self._anew, best.beginning), range(number, number + PARTS), best, 1)
        elif self.effort.more:
            same = partial(begun, settings=best.beginning.task.settings)
            best = self._best_of(same, range(first, tries), best)
        return improve(best.beginning, callback=self._last())

    def _spread(self) -> float:
        """The standard deviation of the first tries' figures that were begun in one way."""
        figures = [self._figures[number] for number in range(self.effort.first)]
        ways = [figures[way :: len(self.ways)] for way in range(len(self.ways))]
        return float(np.sqrt(np.mean([np.var(way) for way in ways if way])))

    def _best_of(
        self, make: Callable[[int], Beginning], numbers: Sequence[int], best: Ranked | None, share: int = PARTS
    ) -> Ranked:
        """The best, or of equals the first, of the best so far and of those that are made; threads share these.

        share: how many of a try's PARTS each is.
        """

        def keep(number: int) -> None:
            nonlocal best
            made = self._ranked(number, make(number))
            with self._telling:
                best = made if best is None else min(best, made, key=lambda one: one[:2])
                self._figures[number] = made.figure
                self._tell(made, share)

        apart(keep, numbers, min(torch.get_num_threads() + 1, max(BESIDE // math.prod(self.size), 1)))
        assert best is not None
        return best

    def _anew(self, beginning: Beginning, number: int) -> Beginning:
        """A beginning with a part of it laid anew, anywhere."""
        seed = self._seed(number)
        generator = generator_of(seed)
        first, extent = list[int](), list[int]()
        for side, (place, share) in zip(
            self.size, torch.rand(len(self.size), 2, generator=generator).tolist(), strict=True
        ):
            extent.append(max(round((LEAST + (MOST - LEAST) * share) * side), 1))
            first.append(math.floor(place * side) - extent[-1] // 2)  # some lie across the border
        wraps = beginning.task.wraps
        return beginning.anew(Box(tuple(first), tuple(extent)).clipped(self.size, wraps), seed)

    def _ranked(self, number: int, beginning: Beginning) -> Ranked:
        """A beginning with its figure: of quality, of how large its copies are, and of what is seen of its seams."""
        image, where = beginning.copied()
        figure = self._ranking(image.cpu()) + PASTED * pasted(where, self._area)
        figure += TORN * math.log(visible_seams(self.source, where) + LEAST_TORN)
        return Ranked(figure, number, beginning)

    def _seed(self, number: int) -> int:
        return self.seed + 1000 * number

    def _tell(self, made: Ranked, share: int) -> None:
        """Tell the callback of one more share of a try that is done; what is left then counts as one try."""
        self._done += share
        if self.callback is not None:
            fraction, image = self._done / PARTS / (self.effort.tries + 1), made.beginning.copied()[0]
            attempt = -(-self._done // PARTS)
            self.callback(Progress(fraction, 0, 0, made.figure, image, attempt, self.effort.tries))

    def _last(self) -> Callable[[Progress], None] | None:
        """The callback for what is made of the best, once all are tried."""
        callback, tries = self.callback, self.effort.tries
        if callback is None:
            return None
        return lambda p: callback(replace(p, fraction=(tries + p.fraction) / (tries + 1), attempt=tries, tries=tries))
