"""Several tries of which the best is kept."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import Lock
from typing import TypeVar

from kwatra import Exemplar, Progress, Result
from kwatra.base import shared, threads_shared, whole_seed
from kwatra.scoring import Ranking

Made = TypeVar("Made")

BESIDE = 2**20
"""Tries are made side by side, a thread each, of so many pixels together: memory stays that of one of 1024 a side.

Where threads cannot share them evenly, one more is under way than there are threads, so that none is left to be made
alone: three tries by two threads are so made 1.5 to 1.65 times as fast as by one, in place of 1.34 to 1.44. Where they
can, one more waits for the interpreter: six tries are made 1.7 times as fast, 1.6 with three under way."""


def seed_of(seed: int, number: int) -> int:
    """The seed of one of several tries, from 0; the first has the seed itself."""
    return whole_seed(seed) + 1000 * number


def beside(call: Callable[[int], Made], numbers: Sequence[int], size: Sequence[int]) -> list[Made]:
    """What a call makes of each of several tries of a `size` (*S), by number; as many side by side as BESIDE allows."""
    threads = threads_shared()
    together = threads + (len(numbers) % threads > 0)
    return shared(call, numbers, min(together, max(BESIDE // math.prod(size), 1)))


def share_of(callback: Callable[[Progress], None], number: int, count: int) -> Callable[[Progress], None]:
    """The callback for one of several parts of the work, with its fraction as a share of all."""
    return lambda p: callback(replace(p, fraction=(number + p.fraction) / count))


class Runs:
    """Several runs of a `size` (*S) of which the best is kept; of images, only the first `channels` are.

    finish: done to each result. callback: called from one thread at a time, not always the same.
    """

    def __init__(
        self,
        count: int,
        size: Sequence[int],
        seed: int,
        callback: Callable[[Progress], None] | None,
        channels: int,
        finish: Callable[[Result], Result] | None = None,
    ) -> None:
        self.count, self.size, self.seed, self.callback, self.channels = count, size, seed, callback, channels
        self.finish = finish
        self._done, self._telling = [0.0] * count, Lock()

    def best(self, run: Callable[..., Result], source: Exemplar) -> Result:
        """The run, told its seed and callback, whose result measures best against the exemplar."""
        if self.count == 1:
            return self._image_of(run(seed=self.seed, callback=self.callback))
        pictures = [picture[: self.channels] for picture in source.pictures()]
        figure = Ranking(pictures, thorough=True)
        best: tuple[float, int, Result] | None = None

        def make(number: int) -> None:
            nonlocal best
            if number == 1 and len(self.size) == 2:  # meanwhile the first looks at the texture
                figure.describe((len(pictures[0]), *self.size))
            result = self._image_of(run(seed=seed_of(self.seed, number), callback=self._part(number)))
            overall = figure(result.image.cpu())
            self._done[number] = 1.0
            with self._telling:
                if best is None or (overall, number) < best[:2]:
                    best = overall, number, result

        beside(make, range(self.count), self.size)
        assert best is not None
        return best[2]

    def _image_of(self, result: Result) -> Result:
        """The result, finished, without guide channels."""
        result = result if self.finish is None else self.finish(result)
        stages = [replace(stage, image=stage.image[: self.channels]) for stage in result.stages]
        return replace(result, image=result.image[: self.channels], stages=stages)

    def _part(self, number: int) -> Callable[[Progress], None] | None:
        """The callback for one run, with its fraction as a share of all runs."""
        callback, count = self.callback, self.count
        if callback is None:
            return None

        def tell(progress: Progress) -> None:
            with self._telling:
                self._done[number] = progress.fraction
                callback(replace(progress, fraction=sum(self._done) / count, attempt=number + 1, tries=count))

        return tell
