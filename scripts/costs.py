"""What synthesis and quilting cost from one exemplar: seconds of this process once all is loaded, and their ratios."""

import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from synth import synthesize
from synth.quilting import QuiltSettings, quilt

ROUNDS = 3
"""Each is done so often, in turn with the others, and its median is told: machines have slow spells."""

Work = Callable[[], float]
"""Does something, and says how many seconds that took."""


def costs(
    exemplar: Tensor, file: Path, side: int, rivals: dict[str, Callable[[int], float]]
) -> Iterator[tuple[str, float]]:
    """What each is called and its figure, of outputs of `side` pixels and of up to 8 times as many, on one thread.

    file: the exemplar's, for the command line. rivals: what other programs take for outputs of so many pixels a side.
    """
    torch.set_num_threads(1)
    still(exemplar, "fast", side)()  # which loads what is compiled
    sides = {side: ("fast", "default", "best"), 4 * side: ("fast", "default"), 8 * side: ("fast",)}
    works = {f"{preset} {pixels}": still(exemplar, preset, pixels) for pixels in sides for preset in sides[pixels]}
    works |= {f"quilting {pixels}": quilted(exemplar, pixels) for pixels in (2 * side, 4 * side)}
    works |= {
        f"{name} {pixels}": partial(rival, pixels) for name, rival in rivals.items() for pixels in (side, 4 * side)
    }
    words = ["synth", "synth", str(file), "-o", str(file.with_name("command_line.png")), "--overwrite"]
    works["command line, fast"] = process("-m", *words, "--preset", "fast", "--size", f"{side}x{side}")
    works["import torch, numba"] = process("-c", "import torch, numba")
    found = in_turn(works)
    yield from found.items()
    yield "command line, more than its synthesis", found["command line, fast"] - found[f"fast {side}"]
    yield "best, times default", found[f"best {side}"] / found[f"default {side}"]
    yield f"fast, {8 * side} times {4 * side}", found[f"fast {8 * side}"] / found[f"fast {4 * side}"]
    yield f"quilting, {4 * side} times {2 * side}", found[f"quilting {4 * side}"] / found[f"quilting {2 * side}"]
    for preset, pixels in (("default", side), ("default", 4 * side), ("best", side)):
        walls = in_turn({str(n): still(exemplar, preset, pixels, time.perf_counter, n) for n in (1, 2)})
        yield f"{preset} {pixels}, times faster by two threads", walls["1"] / walls["2"]
    yield f"default {side}, times faster by two processes", by_two_processes(exemplar, side)


def still(
    exemplar: Tensor, preset: str, side: int, clock: Callable[[], float] = time.process_time, threads: int = 1
) -> Work:
    """A synthesis, timed by a clock."""

    def work() -> float:
        torch.set_num_threads(threads)
        begun = clock()
        synthesize(exemplar, (side, side), preset=preset)
        return clock() - begun

    return work


def quilted(exemplar: Tensor, side: int) -> Work:
    """A quilting."""

    def work() -> float:
        torch.set_num_threads(1)
        begun = time.process_time()
        quilt(exemplar, (side, side), QuiltSettings())
        return time.process_time() - begun

    return work


def process(*words: str) -> Work:
    """A process of Python with these arguments, all that it takes."""

    def work() -> float:
        begun, environment = child_seconds(), os.environ | {"OMP_NUM_THREADS": "1"}
        subprocess.run([sys.executable, *words], check=True, capture_output=True, env=environment)
        return child_seconds() - begun

    return work


def child_seconds() -> float:
    """What all processes took that this one began and that have ended, cpu seconds."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def by_two_processes(exemplar: Tensor, side: int) -> float:
    """How many times as fast two stills are made by two processes at once as by one after the other.

    They share nothing, so that is about what this machine lets two threads gain at most.
    """
    pixels = exemplar.numpy()
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:

        def wall(count: int) -> float:
            begun = time.perf_counter()
            list(pool.map(make_still, [pixels] * count, [side] * count))
            return time.perf_counter() - begun

        wall(4)  # which starts both, and loads what is compiled
        walls = in_turn({str(n): partial(wall, n) for n in (1, 2)})
    return 2 * walls["1"] / walls["2"]


def make_still(exemplar: np.ndarray, side: int) -> None:
    """Make a still on one thread."""
    still(torch.from_numpy(exemplar), "default", side)()


def in_turn(works: dict[str, Work]) -> dict[str, float]:
    """The median of what each takes."""
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(ROUNDS):
        for name, work in works.items():
            taken[name].append(work())
    return {name: statistics.median(values) for name, values in taken.items()}
