"""The EM loop: texture synthesis as the minimization of one energy (thesis algorithms 1 and 2).

    U(x) = sum_p w_p |x_p - z_p|^2_G + sum_k lambda_k (x - c_k)^T F_k (x - c_k)

Each iteration searches for every window x_p of the image the source window z_p that explains it best, weighs the
windows robustly, and blends: solves for the x that minimizes U with the z_p fixed. Levels run coarse to fine.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import enlarged
from kwatra.exemplar import Exemplar
from kwatra.levels import Level
from kwatra.loop.beginning import Beginning, begin
from kwatra.loop.scene import Estimate, Scene
from kwatra.loop.task import Task
from kwatra.result import Progress, Result, Row, Stage
from kwatra.settings import Settings
from kwatra.source import Prepared, Texture, sourcemap
from kwatra.step import Step
from kwatra.terms import Sum, TermLike

SETTLED = 0.005
"""A level ends when fewer than this share of its matches change: a bound on time. With 0 two stills are the same bits,
with .02 one of them differs by .001 of the range."""

BESIDE = 2
"""So many pixels beside what was changed stay as they are copied. By eye, on stones."""

Between = Callable[[Tensor, Step], Tensor]


def optimize(
    texture: Exemplar | Prepared | Texture,
    shape: Sequence[int],
    *,
    settings: Settings | None = None,
    terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
    mask: Tensor | None = None,
    start: Tensor | str = "aligned",
    seed: int = 0,
    between: Between | None = None,
    callback: Callable[[Progress], None] | None = None,
) -> Result:
    """Synthesize an image or video of spatial `shape` that looks like the texture and satisfies the terms.

    texture: an exemplar; or a `Prepared` one, which keeps its windows for the next call; or what else has windows, such
    as `Bags`. shape: (H, W) or (T, H, W). mask: boolean (*shape), True where texture belongs; what the start and the
    terms hold behind it has no influence, and the result has the start image's pixels there, or 0. start: what to
    improve, an image (C, *shape) or one that is made: "aligned" (blocks that continue each other), "blocks" (blocks at
    random), "windows" (the average of random windows, as in the thesis) or "terms" (of windows that please the terms
    alone, thesis 7.1). between: applied to the image after each blend, with the `Step`. callback: told after each
    iteration. Runs on the texture's device. Memory grows with the output and with the exemplar, never with their
    product. Raises InputError for what cannot be done, FloatingPointError should the energy or the image cease to be
    finite.
    """
    beginning = begin(texture, shape, settings, terms, mask, start, seed).without_blocks()
    return improve(beginning, between, callback)


def improve(
    beginning: Beginning, between: Between | None = None, callback: Callable[[Progress], None] | None = None
) -> Result:
    """What the levels make of a beginning, which stays as it is; the rest is as in `optimize`."""
    image, where, factors = beginning.image, beginning.where, beginning.factors
    task = replace(beginning.task, generator=beginning.task.generator.clone_state())
    report, stopped = _Report(task.levels, callback), ""
    if beginning.finished and between is None and image is not None:
        return _as_begun(task, image, where, factors, report)
    for number, level in enumerate(task.levels):
        scene = Scene(task, number)
        estimate = scene.enter(image, where, factors)
        with scene.sharing(estimate.layout, estimate.matches is not None) if between is None else nullcontext():
            estimate, stopped = _iterate(scene, estimate, report, between)
            image, where, factors = estimate.image, scene.where(estimate), scene.factors
        if where is not None and between is None and number == len(task.levels) - 1:
            image, where = _uncut(beginning, image, where, factors)
        report.stages.append(Stage(number, level.factor, level.width, image))
    assert image is not None  # there is at least one level
    return _result(task, image, where, factors, report, stopped)


def _as_begun(task: Task, image: Tensor, where: Tensor | None, factors: tuple[int, ...], report: "_Report") -> Result:
    """The result where nothing is left to improve: no level is done.

    Where an exemplar goes on by itself what meets where it ends is in none of its windows, so EM would only undo it.
    """
    report.done(image)
    image = task.controls(factors).held(image)
    return _result(task, image, where, factors, report, "nothing was left to improve")


def _uncut(beginning: Beginning, image: Tensor, where: Tensor, factors: tuple[int, ...]) -> tuple[Tensor, Tensor]:
    """An image and its source map, with the copies of the beginning back wherever their seams cut elements less.

    Left as they are: other resolutions than the beginning's, and outputs that are steered by terms.
    """
    task, before, exemplar = beginning.task, beginning.where, beginning.task.texture.exemplar
    if beginning.gaps is None or before is None or exemplar is None or task.terms:
        return image, where
    if not max(beginning.factors) == max(factors) == 1:
        return image, where
    take, (copied, _) = beginning.gaps.cheaper(before, where, task.wraps), beginning.copied()
    if beginning.fitted is not None:  # beside what was changed all is a seam, EM dots joints with other elements
        take &= ~_near(beginning.fitted.changed)
    if task.mask is not None:
        take |= ~task.mask
    return torch.where(take, image, copied), torch.where(take, where, before)


def _near(changed: Tensor) -> Tensor:
    """Where (H, W) pixels are changed (H, W), or near such."""
    return F.max_pool2d(changed[None].float(), 2 * BESIDE + 1, 1, BESIDE)[0] > 0


def _iterate(scene: Scene, estimate: Estimate, report: "_Report", between: Between | None) -> tuple[Estimate, str]:
    """EM iterations on one level until the matches settle or their number is spent; and why it stopped."""
    level = scene.level
    while estimate.iteration < level.iterations:
        estimate, row = scene.step(estimate)
        if not math.isfinite(estimate.energy):
            raise FloatingPointError(f"the energy became {estimate.energy} in iteration {estimate.iteration}")
        if between is not None:
            image = scene.controls.held(between(estimate.image, scene.context(estimate.iteration, estimate)))
            if not bool(image.isfinite().all()):
                raise FloatingPointError(f"`between` made pixels NaN or infinite in iteration {estimate.iteration}")
            estimate = replace(estimate, image=image)
        report.add(scene.number, estimate, row)
        if estimate.changed < SETTLED:
            return estimate, f"the matches settled: fewer than {SETTLED:.1%} changed in iteration {estimate.iteration}"
    done = "the one iteration was" if level.iterations == 1 else f"all {level.iterations} iterations were"
    return estimate, f"{done} done"


def _result(
    task: Task,
    image: Tensor,
    where: Tensor | None,
    factors: tuple[int, ...],
    report: "_Report",
    stopped: str,
) -> Result:
    """The result at full resolution; levels that end below it show their matches there, or are enlarged."""
    full = task.controls((1,) * len(task.shape))
    exemplar = task.texture.exemplar
    if where is not None and exemplar is not None:
        if max(factors) > 1:
            where = sourcemap.finer(where, factors, task.shape)
            image = full.held(sourcemap.look_up(exemplar.canvas, where))
        source = sourcemap.look_up(exemplar.origin, where)
        if full.given is not None:
            source[:1] = torch.where(full.given.free, source[:1], -1)
    else:
        where = source = torch.empty(0, *task.shape, dtype=torch.long, device=image.device)
        image = full.held(enlarged(image, task.shape))
    if task.mask is not None and task.image is not None:
        image = torch.where(task.mask, image, task.image)
    return Result(image, source, where, report.rows, report.stages, stopped)


class _Report:
    """Collects what the result tells, and tells the callback."""

    def __init__(self, levels: Sequence[Level], callback: Callable[[Progress], None] | None) -> None:
        self.levels, self.callback = levels, callback
        self.rows: list[Row] = []
        self.stages: list[Stage] = []
        work = [level.iterations / level.factor**2 for level in levels]
        self._done = [sum(work[:i]) / sum(work) for i in range(len(work) + 1)]

    def done(self, image: Tensor) -> None:
        """Tell of an image on which there is nothing to do."""
        if self.callback is not None:
            self.callback(Progress(1.0, 0, 0, 0.0, image))

    def add(self, number: int, estimate: Estimate, row: Row) -> None:
        level = self.levels[number]
        place: Row = {"level": number, "factor": level.factor, "width": level.width, "iteration": estimate.iteration}
        self.rows.append(place | row)
        if self.callback is not None:
            share = 1.0 if estimate.changed < SETTLED else estimate.iteration / level.iterations
            fraction = self._done[number] + share * (self._done[number + 1] - self._done[number])
            self.callback(Progress(fraction, number, estimate.iteration, estimate.energy, estimate.image))
