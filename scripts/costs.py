"""What synthesis and quilting cost from one exemplar: seconds of this process once all is loaded, and their ratios."""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

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
    works["command line, fast"] = command_line(file, side)
    found = in_turn(works)
    yield from found.items()
    yield "command line, more than its synthesis", found["command line, fast"] - found[f"fast {side}"]
    yield "best, times default", found[f"best {side}"] / found[f"default {side}"]
    yield f"fast, {8 * side} times {4 * side}", found[f"fast {8 * side}"] / found[f"fast {4 * side}"]
    yield f"quilting, {4 * side} times {2 * side}", found[f"quilting {4 * side}"] / found[f"quilting {2 * side}"]
    for preset, pixels in (("default", side), ("default", 4 * side), ("best", side)):
        walls = in_turn({str(n): still(exemplar, preset, pixels, time.perf_counter, n) for n in (1, 2)})
        yield f"{preset} {pixels}, times faster by two threads", walls["1"] / walls["2"]


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


def command_line(file: Path, side: int) -> Work:
    """`kwatra synth` of a file, all that the process takes."""
    words = [str(file), "-o", str(file.with_name("command_line.png")), "--overwrite", "--preset", "fast"]
    command = [sys.executable, "-m", "synth", "synth", *words, "--size", f"{side}x{side}"]

    def work() -> float:
        begun = os.times()
        subprocess.run(command, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        done = os.times()
        return done.children_user + done.children_system - begun.children_user - begun.children_system

    return work


def in_turn(works: dict[str, Work]) -> dict[str, float]:
    """The median of what each takes."""
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(ROUNDS):
        for name, work in works.items():
            taken[name].append(work())
    return {name: statistics.median(values) for name, values in taken.items()}
