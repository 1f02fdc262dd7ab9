"""Stills that nothing steers: several beginnings are tried, and parts of the best laid anew, before it is optimized.

Tries are drafts, blocks laid once: which is good is told by them, and only the best few are refined. What a part is
replaced by counts for itself: those few are kept with which the whole is better, and gains add up, where of whole tries
one has to be better everywhere. But parts go on as what lies around them has it: what is wrong with the whole, as rows
that do not meet, only another try mends. Tries then differ much.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from threading import Lock
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from kwatra import Beginning, Exemplar, Progress, Result, Settings, improve
from kwatra.base import generator_of, shared, threads_shared
from kwatra.loop import looks
from kwatra.pieces import Box, visible_seams
from kwatra.scoring import Ranking, pasted
from synth.texture.runs import beside, seed_of, share_of

TORN, LEAST_TORN = 0.01, 1e-4
"""How many times the logarithm of what seams show counts beside the figure that tries are ranked by, and what is added
to it first. Figures are blind to what is torn, and like it: a tartan shows more of its exemplar then. 22 textures score
.0486 in place of .0484, and of 20 tries of a tartan a whole one is kept in place of a torn one."""

PASTED = 0.12, 0.06
"""What the square of the mean size of copies counts, as a part of the exemplar, the second where tries are ranked
thoroughly: figures like what is pasted as a whole, the more the larger it is, and the rougher they are.

Of stills of two panels of 16 textures, two seeds, by `default`, copies are .225 and .216 of their exemplar at a time,
of one .55 and of no other more than .37, and they score .0555 and .0501, with .12; .245 and .246, of five .39 to .59,
.0558 and .0482 with .06; .197, .197, .0575 and .0518 with .2. Those of the first panel by `best` score .0478 with .06,
.0480 with .07 and .0482 with .09, and copy .224 with .06."""

REFINED = 2
"""So many drafts are refined, the best. Of six tries of the textures of a panel, two seeds, the best has a figure of
-.0069; where one is refined -.0065, two -.0069; the best of five tries has -.0065."""

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
        """How many tries there are, PARTS parts being one, and to refine a draft another."""
        return 1 if self.first + self.more == 1 else self.first + self.more + REFINED


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
        pictures, thorough = source.pictures(), effort.more > 0
        self._ranking, self._pasted = Ranking(pictures, thorough=thorough), PASTED[thorough]
        self._channels, self._area = len(pictures[0]), sum(picture[0].numel() for picture in pictures)
        self._done, self._telling = 0, Lock()

    def best(self, begin: Callable[..., Beginning]) -> Result:
        """What is made of the best beginning; each is told its settings and seed.

        Memory is that of as many beginnings as are tried together, one for each way, and REFINED drafts.
        """
        return improve(self._found(begin).without_blocks(), callback=self._rest())

    def _found(self, begin: Callable[..., Beginning]) -> Beginning:
        """The best beginning."""
        first, more = self.effort.first, self.effort.more
        known = dict[int, Beginning]()  # one that is made in each way

        def begun(number: int) -> Beginning:
            way = number % len(self.ways)
            if way in known:
                return self._afresh(known[way], number)
            made = begin(settings=self.ways[way], seed=seed_of(self.seed, number), draft=self.effort.tries > 1)
            if made.blocks is not None:
                known[way] = made
            return made

        if threads_shared() > 1:
            self._look()
        if self.effort.tries == 1:
            return begun(0)
        drafts, figures = self._best_of(begun, range(first), [], REFINED)
        if drafts[0].beginning.blocks is None:  # of what is exactly periodic all are the same
            return drafts[0].beginning
        alike = self._spread(figures) < ALIKE
        if more > 0 and not alike:
            afresh = partial(self._afresh, drafts[0].beginning)
            drafts, _ = self._best_of(afresh, range(first, first + more), drafts, REFINED)
        best, _ = self._best_of(lambda number: drafts[number].beginning.refined(), range(len(drafts)), [])
        for number in range(first, first + PARTS * more, PARTS) if alike else ():
            anew = partial(self._anew, best[0].beginning)
            best, _ = self._best_of(anew, range(number, number + PARTS), best, share=1)
        return best[0].beginning

    def _look(self) -> None:
        """Look at the texture in the ways that tries are going to ask for, side by side."""
        ways = looks(self.source)
        if self.effort.tries > 1:
            ways.insert(0, partial(self._ranking.describe, (self._channels, *self.size)))
        shared(lambda way: way(), ways)

    def _spread(self, figures: Sequence[float]) -> float:
        """The standard deviation of the first tries' figures that were begun in one way."""
        ways = [figures[way :: len(self.ways)] for way in range(len(self.ways))]
        return float(np.sqrt(np.mean([np.var(way) for way in ways if way])))

    def _best_of(
        self,
        make: Callable[[int], Beginning],
        numbers: Sequence[int],
        best: Sequence[Ranked],
        most: int = 1,
        share: int = PARTS,
    ) -> tuple[list[Ranked], list[float]]:
        """The best few, of equals the first, of the best so far and of those that are made; and the figures of these.

        Threads share them. share: how many of a try's PARTS each is.
        """
        best = list(best)

        def keep(number: int) -> float:
            beginning = make(number)
            image, where = beginning.copied()
            made = Ranked(self._figure(image, where), number, beginning)
            with self._telling:
                best.append(made)
                best.sort(key=lambda one: one[:2])
                del best[most:]
                self._tell(made.figure, image, share)
            return made.figure

        figures = beside(keep, numbers, self.size)
        return best, figures

    def _afresh(self, beginning: Beginning, number: int) -> Beginning:
        """A beginning as another one, with a seed of its own."""
        return beginning.afresh(seed_of(self.seed, number))

    def _anew(self, beginning: Beginning, number: int) -> Beginning:
        """A beginning with a part of it laid anew, anywhere."""
        seed = seed_of(self.seed, number)
        first, extent = list[int](), list[int]()
        drawn = torch.rand(len(self.size), 2, dtype=torch.float32, generator=generator_of(seed)).tolist()
        for side, (place, share) in zip(self.size, drawn, strict=True):
            extent.append(max(round((LEAST + (MOST - LEAST) * share) * side), 1))
            first.append(math.floor(place * side) - extent[-1] // 2)  # some lie across the border
        wraps = beginning.task.wraps
        return beginning.anew(Box(tuple(first), tuple(extent)).clipped(self.size, wraps), seed)

    def _figure(self, image: Tensor, where: Tensor) -> float:
        """Of copies and their source map: of quality, of how large copies are, and of what is seen of their seams."""
        figure = self._ranking(image.cpu()) + self._pasted * pasted(where, self._area) ** 2
        return figure + TORN * math.log(visible_seams(self.source, where) + LEAST_TORN)

    def _tell(self, figure: float, image: Tensor, share: int) -> None:
        """Tell the callback of one more share of a try that is done; what is left then counts as one try."""
        self._done += share
        if self.callback is not None:
            tries, attempt = self.effort.tries, -(-self._done // PARTS)
            self.callback(Progress(self._done / PARTS / (tries + 1), 0, 0, figure, image, attempt, tries))

    def _rest(self) -> Callable[[Progress], None] | None:
        """The callback for what is made of the best, once all are tried."""
        callback, tries = self.callback, self.effort.tries
        if callback is None or tries == 1:
            return callback
        return share_of(lambda p: callback(replace(p, attempt=tries, tries=tries)), tries, tries + 1)
