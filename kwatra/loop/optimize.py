"""The EM loop: texture synthesis as the minimization of one energy (thesis algorithms 1 and 2).

    U(x) = sum_p w_p |x_p - z_p|^2_G + sum_k lambda_k (x - c_k)^T F_k (x - c_k)

Each iteration searches for every window x_p of the image the exemplar window z_p that explains it best, weighs the
windows robustly, and blends: solves for the x that minimizes U with the z_p fixed. Levels run coarse to fine.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import torch
from torch import Tensor

from kwatra.base import InputError, factors_of, generator_of, whole_sizes
from kwatra.exemplar import Exemplar
from kwatra.levels import Level, planned_levels
from kwatra.loop.scene import Scene, State
from kwatra.pieces import BlockStart, block_size
from kwatra.result import Progress, Result, Row, Stage
from kwatra.settings import Settings
from kwatra.source import Prepared, sourcemap
from kwatra.terms import Controls, Sum, TermLike, check_controls, check_mask, parts_of


def optimize(
    exemplar: Exemplar | Prepared,
    shape: Sequence[int],
    *,
    settings: Settings | None = None,
    terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
    mask: Tensor | None = None,
    start: Tensor | None = None,
    seed: int = 0,
    between: Callable[[Tensor, Exemplar], Tensor] | None = None,
    callback: Callable[[Progress], None] | None = None,
) -> Result:
    """Synthesize an image or video of spatial `shape` that looks like the exemplar and satisfies the terms.

    shape: (H, W) or (T, H, W). mask: boolean (*shape), True where texture belongs; what the start and the terms hold
    behind it has no influence, and the result has the start's pixels there, or 0. start: an image (C, *shape) to
    improve instead of beginning anew. between: applied to the image after each blend, with the exemplar at the
    level's resolution. callback: told after each iteration. A `Prepared` exemplar keeps its windows for the next
    call. Runs on the exemplar's device. Memory grows with the output and with the exemplar, never with their product.
    Raises InputError for what cannot be done, FloatingPointError should the energy cease to be finite.
    """
    settings = settings or Settings()
    prepared = exemplar if isinstance(exemplar, Prepared) else None
    exemplar = exemplar.exemplar if isinstance(exemplar, Prepared) else exemplar
    shape = whole_sizes(shape, len(exemplar.shape))
    single_terms, mask = parts_of(terms), check_mask(mask, shape)
    _check(exemplar, shape, start, mask)
    full = _full_controls(exemplar, shape, single_terms, mask)
    generator = generator_of(seed)
    levels = settings.levels or planned_levels(exemplar, shape, settings.iterations)
    report = _Report(levels, callback)
    image, where, factors = start, None, (1,) * len(shape)
    stopped = ""
    if start is None and settings.start != "windows":
        where, factors = block_start(exemplar, shape, levels, settings, generator, single_terms, mask)
    for number, level in enumerate(levels):
        scene = Scene(prepared or Prepared(exemplar), shape, single_terms, level, settings, generator, mask)
        state = scene.enter(image, where, factors)
        state, stopped = _iterate(scene, state, report, number, between)
        assert state.matches is not None
        image, factors = state.image, scene.factors
        where = sourcemap.winners(scene.grid, scene.source, state.matches, state.weights)
        report.stages.append(Stage(number, level.factor, level.width, image))
    assert image is not None  # there is at least one level
    assert where is not None
    if max(factors) > 1:  # the levels asked for end below full resolution: show their matches at it
        where = sourcemap.finer(where, factors, shape)
        image = full.held(sourcemap.look_up(exemplar.canvas, where))
    source = sourcemap.look_up(exemplar.origin, where)
    if full.given is not None:
        source[:1] = torch.where(full.given.free, source[:1], -1)
    if mask is not None and start is not None:
        image = torch.where(mask, image, start)
    return Result(image, source, where, report.rows, report.stages, stopped)


def _iterate(
    scene: Scene,
    state: State,
    report: "_Report",
    number: int,
    between: Callable[[Tensor, Exemplar], Tensor] | None,
) -> tuple[State, str]:
    """EM iterations on one level until the matches settle or their number is spent; and why it stopped."""
    level, tolerance = scene.level, scene.settings.tolerance
    while state.iteration < level.iterations:
        state, row = scene.step(state)
        if not math.isfinite(state.energy):
            raise FloatingPointError(f"the energy became {state.energy} in iteration {state.iteration}")
        if between is not None:
            image = scene.controls.held(between(state.image, scene.source.exemplar))
            state = replace(state, image=image)
        report.add(number, state, row)
        if state.changed < tolerance:
            return state, f"the matches settled: fewer than {tolerance:.1%} changed in iteration {state.iteration}"
    done = "its one iteration was done" if level.iterations == 1 else f"all {level.iterations} iterations were done"
    return state, done


def block_start(
    exemplar: Exemplar,
    shape: tuple[int, ...],
    levels: Sequence[Level],
    settings: Settings,
    generator: torch.Generator,
    terms: Sequence[TermLike] = (),
    mask: Tensor | None = None,
) -> tuple[Tensor, tuple[int, ...]]:
    """A source map of copied blocks and its resolution: the finest at which laying them costs little.

    Blocks agree with what the terms want; a mask only hides that, blocks run on behind it.
    """
    axes = len(shape)
    coarsest = max(level.factor for level in levels)
    factor = 1
    while factor < coarsest and min(exemplar.extent[-2:]) / factor > 160:
        factor *= 2
    factors, grain = factors_of(factor, axes), factors_of(coarsest // factor, axes)
    here = exemplar.coarser(factors)
    controls = Controls(terms, mask, factors, shape, len(here.weights), here.canvas.device)
    there = controls.shape
    wish = controls.wish(torch.zeros(len(here.weights), *there, device=here.canvas.device))
    block = block_size(here, there, settings.block, grain)
    aligned = settings.start == "aligned"
    blocks = BlockStart(
        here,
        there,
        block,
        grain,
        generator,
        wrap=settings.wrap,
        usage=settings.usage,
        aligned=aligned,
        seams=settings.seams,
        wish=wish,
    )
    return blocks.run(), factors


def _full_controls(
    exemplar: Exemplar, shape: tuple[int, ...], terms: Sequence[TermLike], mask: Tensor | None
) -> Controls:
    """The controls at full resolution, checked."""
    channels, device = len(exemplar.weights), exemplar.canvas.device
    controls = Controls(terms, mask, (1,) * len(shape), shape, channels, device)
    check_controls(controls, torch.zeros(channels, *shape, device=device))
    return controls


class _Report:
    """Collects what the result tells, and tells the callback."""

    def __init__(self, levels: Sequence[Level], callback: Callable[[Progress], None] | None) -> None:
        self.levels, self.callback = levels, callback
        self.rows: list[Row] = []
        self.stages: list[Stage] = []
        work = [level.iterations / level.factor**2 for level in levels]
        self._done = [sum(work[:i]) / sum(work) for i in range(len(work) + 1)]

    def add(self, number: int, state: State, row: Row) -> None:
        level = self.levels[number]
        place: Row = {"level": number, "factor": level.factor, "width": level.width, "iteration": state.iteration}
        self.rows.append(place | row)
        if self.callback is not None:
            share = state.iteration / level.iterations
            fraction = self._done[number] + share * (self._done[number + 1] - self._done[number])
            self.callback(Progress(fraction, number, state.iteration, state.energy, state.image))


def _check(exemplar: Exemplar, shape: tuple[int, ...], start: Tensor | None, mask: Tensor | None) -> None:
    if start is None:
        return
    if tuple(start.shape) != (len(exemplar.weights), *shape):
        raise InputError(
            f"the start image has shape {tuple(start.shape)}; the output needs {(len(exemplar.weights), *shape)}"
        )
    if not bool((start if mask is None else start[:, mask]).isfinite().all()):
        raise InputError("the start image holds NaN or infinite pixels; replace them first")
