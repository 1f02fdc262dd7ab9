"""What the optimization begins with: copies laid of an exemplar, something random, or an image that is given."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from kwatra.base import InputError, continued, generator_of
from kwatra.exemplar import Exemplar
from kwatra.loop.laying import block_start, repeated
from kwatra.loop.recognition import recognized
from kwatra.loop.task import Task, task_of
from kwatra.pieces import BlockStart, Box, Fitted, Gaps, SlantedStart
from kwatra.settings import Settings
from kwatra.source import Prepared, Texture, read_warped, sourcemap
from kwatra.terms import Sum, TermLike


@dataclass(frozen=True, eq=False)
class Beginning:
    """What the first level of a task begins with: an image (C, *S), a source map (n, *S), neither or both.

    factors: the resolution that both have. gaps: those in which the source map's seams are hidden, where elements are
    known; fitted: what is shown where elements were made whole, None where none were. blocks: those that it is of, None
    if it is of none, or nothing of it is to be laid anew. finished: whether nothing is left to improve, as where its
    exemplar goes on by itself.
    """

    task: Task
    image: Tensor | None
    where: Tensor | None
    factors: tuple[int, ...]
    gaps: Gaps | None = None
    fitted: Fitted | None = None
    blocks: BlockStart | SlantedStart | None = None
    finished: bool = False

    def copied(self) -> tuple[Tensor, Tensor]:
        """The image (C, *shape) that is copied together, and its source map (n, *shape), at full resolution.

        Raises InputError where nothing is copied yet.
        """
        exemplar = self.task.texture.exemplar
        if self.where is None or exemplar is None:
            raise InputError("the optimization begins with no copies; start it as 'aligned' or 'blocks' to see some")
        where = sourcemap.carried(self.where, self.factors, (1,) * len(self.factors), self.task.shape)
        return self.shown(exemplar.canvas, where), where

    def shown(self, values: Tensor, where: Tensor) -> Tensor:
        """What a source map (n, *shape) at full resolution shows of values (C, *canvas) of the exemplar: (C, *shape).

        Elements that were made whole here are read between pixels where the map tells of them as this beginning does.
        """
        read, exemplar, fitted = sourcemap.look_up(values, where), self.task.texture.exemplar, self.fitted
        if fitted is None or exemplar is None or max(self.factors) > 1:
            return read
        warped = read_warped(continued(values, exemplar.owner), fitted.places, fitted.detail, fitted.share)
        return torch.where(fitted.changed & (where == fitted.places.round()).all(0), warped, read)

    def anew(self, part: Box, seed: int) -> "Beginning":
        """Another beginning, with blocks laid anew in a part of the output, given in its pixels; this one stays.

        Raises InputError where no blocks are laid.
        """
        blocks = self._laid
        start = tuple(s // f for s, f in zip(part.start, self.factors, strict=True))
        stop = tuple(-(-s // f) for s, f in zip(part.stop, self.factors, strict=True))
        box = Box(start, tuple(b - a for a, b in zip(start, stop, strict=True)))
        generator = generator_of(seed)
        return self._of(blocks.anew(box.clipped(blocks.shape, blocks.wraps), generator), generator)

    def refined(self) -> "Beginning":
        """What `begin` makes in place of this draft, which stays; itself where it is none."""
        if self.blocks is None or not self.blocks.draft:
            return self
        generator = self.task.generator.clone_state()
        return self._of(self.blocks.refined(generator), generator)

    def afresh(self, seed: int) -> "Beginning":
        """What `begin` makes of the same with another seed, for which all is known of its blocks; this one stays.

        Raises InputError where no blocks are laid.
        """
        generator = generator_of(seed)
        return self._of(self._laid.afresh(generator), generator)

    @property
    def _laid(self) -> BlockStart | SlantedStart:
        """Its blocks."""
        if self.blocks is None:
            raise InputError("the optimization begins with no blocks to lay anew; start it as 'aligned' or 'blocks'")
        return self.blocks

    def _of(self, blocks: BlockStart | SlantedStart, generator: torch.Generator) -> "Beginning":
        """The same of other blocks, and going on with another generator."""
        task = replace(self.task, generator=generator)
        return replace(self, task=task, where=blocks.where, fitted=blocks.fitted, blocks=blocks)

    def as_copied(self) -> "Beginning":
        """The same at full resolution, of which nothing is improved: all stays as it is copied together."""
        image, where = self.copied()
        return replace(self, image=image, where=where, factors=(1,) * len(self.factors), finished=True)

    def without_blocks(self) -> "Beginning":
        """The same, of which nothing is laid anew: the memory of its blocks is then free while it improves."""
        return replace(self, blocks=None)


def begin(
    texture: Exemplar | Prepared | Texture,
    shape: Sequence[int],
    settings: Settings | None = None,
    terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
    mask: Tensor | None = None,
    start: Tensor | str = "aligned",
    seed: int = 0,
    draft: bool = False,
) -> Beginning:
    """What `optimize` begins with; arguments and errors are its.

    draft: blocks are laid once only, not again where seams cost most, and elements are not made whole: that is half of
    the cost, and changes little in which of several is best. `Beginning.refined` does it then. A picture that goes on
    by itself is continued before any level; the finest are kept for what `between` asks for.
    """
    task = task_of(texture, shape, settings or Settings(), terms, mask, start, seed)
    factors, exemplar = (1,) * len(task.shape), task.texture.exemplar
    if exemplar is None or task.start not in ("aligned", "blocks"):
        return Beginning(task, task.image, None, factors)
    seen = _recognized(task, exemplar)
    where = repeated(seen, exemplar)
    if where is not None:
        finest = tuple(level for level in task.levels if level.factor == 1)
        image = sourcemap.look_up(exemplar.canvas, where)
        return Beginning(replace(task, levels=finest), image, where, factors, finished=True)
    laid = block_start(seen, exemplar, draft)
    return Beginning(task, None, laid.where, laid.factors, laid.blocks.gaps, laid.blocks.fitted, laid.blocks)


def _recognized(task: Task, exemplar: Exemplar) -> Task:
    """The task as blocks see it that go on from each other: of a still's kept pixels they know what they are."""
    if task.start != "aligned" or len(task.shape) > 2 or not task.terms:
        return task
    return replace(task, terms=recognized(task.terms, exemplar), made={})
