"""The work of a synthesis, in the engine's terms."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic

import numpy as np
import torch
from torch import Tensor

import kwatra
from kwatra import Exemplar, InputError, Level, Prepared, Progress, Result, Settings, Sum, TermLike
from kwatra.base import tensor_of
from kwatra.terms import parts_of
from kwatra.windows import per_axis
from synth.texture.asked import Asked
from synth.texture.easing import eased
from synth.texture.feathering import feathered, passage
from synth.texture.form import Form, Image
from synth.texture.illumination import under_even_light
from synth.texture.light import evened
from synth.texture.moving import in_time
from synth.texture.runs import Runs, share_of
from synth.texture.search import Effort, Search
from synth.texture.staying import staying
from synth.texture.steepness import steepened
from synth.texture.stretch import Memory, Stretch, planned_stretches
from synth.texture.synthesis import Synthesis
from synth.texture.transparency import as_far_as_seen

PRESETS = {
    "fast": (Settings(seams=1, iterations=1), 1),
    "default": (Settings(), 1),
    "best": (Settings(), 6),
}
"""Settings, and how many seeds are tried of which the best result is kept.

Six iterations in place of four make 12 stills of each of 32 textures no better, nor three that follow a guide."""

STILLS, SMALL = {"fast": Effort(1, 0), "default": Effort(6, 0), "best": Effort(12, 20)}, 256
"""How stills are begun that nothing steers, where they have SMALL pixels a side; of larger ones, whose parts even out,
fewer beginnings are tried, in proportion.

Which seed it is matters as much as how well seams are cut: of 32 textures, half of which served for tuning what went
before, one scored .0595, the best of 3 .0550, and that of 24, ranked thoroughly (`kwatra.scoring.Ranking`), .0481.
Later, with parts laid anew, 12 and 10 scored .0462 and 11 and 9 .0466; since bricks are laid whole a panel of 16 scores
.0486 with 12 and 8, .0487 with 24 and 12, .0482 with 20 and 16, .0478 with 12 and 20 and .0474 with 24 and 20, which
takes up to nine times as long as six. Two threads share even numbers evenly. Of two panels of 16 the best of 3 scores
.0558 and .0512, of 4 .0549 and .0508, of 6 .0535 and .0491 (four seeds); the best of 4, with parts laid anew for as
long as two more tries take, .0540, and copies more. Of half a panel 512 pixels a side three score .0581, two .0583 and
one .0586; 1024 a side two are no better than one."""

LARGER = 0.65
"""Every other first try has blocks of so much of the exemplar, and what follows goes the way of the best. Which size is
better depends on the texture: of six tries two panels of 16 textures score .0566 and .0492 with all blocks alike, .0558
and .0482 so (two seeds); a page of text, tissue and wood .115, .058 and .062, and .066, .051 and .060 so (eight); all
of this while large copies weighed half as much in `default` (`PASTED` in `search`)."""


@dataclass(frozen=True, eq=False)
class Work(Generic[Image]):
    """What is to be made, in the engine's terms; channels: those of the exemplar, without a guide's.

    tries: of how many whole results the best is kept. effort: that with which the best beginning is looked for instead,
    of a still that nothing steers. steered: whether something is asked of the output's pixels, so that it can only be
    made as a whole. relit: whether light that falls unevenly was taken out of the source.
    """

    form: Form[Image]
    source: Exemplar
    size: tuple[int, ...]
    settings: Settings
    tries: int
    effort: Effort | None
    terms: tuple[TermLike, ...]
    mask: Tensor | None
    start: Tensor | None
    channels: int
    steered: bool
    relit: bool = False

    @classmethod
    def of(
        cls,
        asked: Asked[Image],
        *,
        preset: str = "default",
        tile: bool = False,
        loop: bool = False,
        stay: float | None = None,
        start: Image | None = None,
        levels: str | Sequence[tuple[int, int]] | None = None,
        mirror: bool = False,
        rotate: Sequence[float] = (),
        scale: Sequence[float] = (),
        terms: TermLike | Sum | Sequence[TermLike | Sum] = (),
        mask: Tensor | np.ndarray | None = None,
        exemplar_mask: Any = None,
        device: str = "cpu",
    ) -> "Work[Image]":
        """The work, checked as far as it can be before it begins; see `synthesize`."""
        form, pictures, guidance = asked.form, asked.pictures, asked.guidance
        shape: tuple[int, ...] = asked.size
        settings = _settings(preset, _wraps(pictures[0], tile, loop), levels)
        begin, channels, weights = None if start is None else form.normalized(start), len(pictures[0]), None
        wanted: tuple[TermLike, ...] = parts_of(terms)
        steered = bool(wanted) or mask is not None or start is not None or guidance is not None
        if guidance is not None:
            settings = guidance.settings(settings, pictures, shape)
            wanted = tuple(guidance.terms(wanted, channels, device))
            pictures, weights = guidance.joined(pictures), guidance.weights(channels)
            begin = None if begin is None else guidance.beside(begin)
        source: Exemplar = Exemplar.of(
            pictures, weights=weights, masks=_masks(exemplar_mask), mirror=mirror, rotate=rotate, scale=scale,
            device=device,
        )  # fmt: skip
        wanted = (*wanted, *staying(stay, source, shape, tile))
        if len(shape) > 2:
            settings = in_time(settings, source)
        effort = _effort(preset, shape) if len(shape) == 2 and not steered else None
        hidden, begin = (None if one is None else tensor_of(one).to(device) for one in (mask, begin))
        work = cls(form, source, shape, settings, PRESETS[preset][1], effort, wanted, hidden, begin, channels, steered)
        return work.evenly_lit()

    def evenly_lit(self) -> "Work[Image]":
        """The same, without light that falls unevenly on its source, unless what is asked for may mean that."""
        meant = bool(self.terms) or self.start is not None
        source = self.source if meant else under_even_light(self.source, self.form.black)
        return self if source is self.source else replace(self, source=source, relit=True)

    def stretches(self) -> list[Stretch]:
        """The parts in which it is made: one, or for a long video that nothing steers several."""
        if len(self.size) == 2 or self.steered:
            return [Stretch.whole(self.size[0])]
        return planned_stretches(self.size, per_axis(self.settings.wrap, 3)[0])

    def run(
        self,
        parts: Sequence[Stretch],
        seed: int,
        callback: Callable[[Progress], None] | None,
        done: int = 0,
        shown: Callable[[int, int], Image] | None = None,
    ) -> Iterator[Synthesis[Image]]:
        """What is not done of the stretches, one after the other."""
        memory = Memory(shown)
        for number, part in enumerate(parts):
            if part.stop <= done:
                continue
            held = part.held(memory, self.form, self.source.canvas.device)
            of_all = None if callback is None else share_of(callback, number, len(parts))
            made = self.made(self.optimized(part, held, seed, of_all), part.behind(done))
            memory.keep(part, made.image, self.form.tensor)
            yield made

    def optimized(
        self, part: Stretch, held: Tensor | None, seed: int, callback: Callable[[Progress], None] | None
    ) -> Result:
        """The best result for a stretch with the frames it holds (C, T, H, W)."""
        settings: Settings = self.settings
        terms: tuple[TermLike, ...] = self.terms
        size = (part.length, *self.size[1:])
        if held is not None:
            settings = replace(settings, wrap=(False, *per_axis(settings.wrap, 3)[1:]))
            terms = (*terms, part.holding(held, size))
        source = Prepared(self.source)  # its windows are described once for all tries
        if self.effort is not None:
            ways = [settings, replace(settings, block=LARGER)] if self.effort.tries > 1 else [settings]
            search = Search(self.effort, ways, size, part.seed(seed), callback, self.source)
            found = search.best(partial(kwatra.begin, source, size, terms=terms))
            return self._eased(found) if settings.levels is None else found
        run = partial(
            kwatra.optimize, source, size, settings=settings, terms=terms, mask=self.mask,
            start="aligned" if self.start is None else self.start,
        )  # fmt: skip
        finish = None if len(size) == 2 or self.steered else partial(self._finished, part, settings)
        runs = Runs(self.tries, size, part.seed(seed), callback, self.channels, finish)
        return runs.best(run, self.source)

    def _eased(self, result: Result) -> Result:
        """The result of a still with its seams eased."""
        image = eased(result.image, result.where, self.source, per_axis(self.settings.wrap, 2))
        return replace(result, image=as_far_as_seen(result.image, image, self.source))

    def _finished(self, part: Stretch, settings: Settings, result: Result) -> Result:
        """The result with seams feathered, strong details and even light; frames a stretch holds are left alone."""
        held = torch.zeros(part.length, dtype=torch.bool)
        held[: part.before], held[part.length - part.after :] = True, True
        wrap = per_axis(settings.wrap, 3)
        soft = feathered(result.image, result.where, self.source, passage(self.source), wrap, ~held)
        sharp = steepened(soft, result.where, self.source, wrap, held)
        image = evened(sharp, result.where, self.source, wrap, held)
        return replace(result, image=as_far_as_seen(soft, image, self.source))

    def made(self, result: Result, part: Stretch) -> Synthesis[Image]:
        """A stretch's result as the exemplar's kind, without the frames it held."""
        if part.before or part.after:
            new = slice(part.before, part.before + part.stop - part.first)
            cut = {name: getattr(result, name)[:, new] for name in ("image", "source", "where")}
            result = replace(result, stages=[], **cut)
        turns = self.source.turned(result.where)
        even = [self.form.restored(picture.cpu()) for picture in self.source.pictures()] if self.relit else []
        return Synthesis(
            self.form.restored(result.image.cpu()), result.source.cpu().numpy(), result, self.form,
            None if turns is None else turns.cpu().numpy(), even,
        )  # fmt: skip


def _wraps(picture: Tensor, tile: bool, loop: bool) -> tuple[bool, ...]:
    """Along which axes the output is periodic."""
    if picture.ndim == 3 and loop:
        raise InputError("the exemplar is an image but a loop is for videos; leave loop out")
    return (loop,) * (picture.ndim - 3) + (tile, tile)


def _settings(preset: str, wrap: tuple[bool, ...], levels: str | Sequence[tuple[int, int]] | None) -> Settings:
    """The settings of a preset."""
    if preset not in PRESETS:
        raise InputError(f"the preset is {preset!r}; allowed are {', '.join(PRESETS)}")
    return replace(PRESETS[preset][0], wrap=wrap, levels=_levels(levels))


def _effort(preset: str, shape: Sequence[int]) -> Effort:
    """With what effort a still of some shape is begun.

    It is as much less than that of a small one as `default` makes fewer tries, so that `best` takes five to eight times
    as long; but seven to eleven where `default` makes one, and need not rank it.
    """
    effort, usual = STILLS[preset], STILLS["default"].first
    tries = max(math.floor(usual * min(SMALL / math.sqrt(math.prod(shape)), 1.0)), 1)
    return Effort(max(effort.first * tries // usual, 1), effort.more * tries // usual)


def _masks(masks: Any) -> list[Tensor] | None:
    """Masks of the exemplars, given as one or as several, tensors or arrays."""
    if masks is None:
        return None
    several = [masks] if isinstance(masks, (Tensor, np.ndarray)) else masks
    return [tensor_of(mask) for mask in several]


def _levels(levels: str | Sequence[tuple[int, int]] | None) -> tuple[Level, ...] | None:
    if levels is None:
        return None
    if isinstance(levels, str):
        if levels != "thesis":
            raise InputError(f"levels is {levels!r}; give 'thesis', or pairs of factor and window width")
        return kwatra.THESIS
    try:
        return tuple(Level(factor, width) for factor, width in levels)
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        raise InputError(f"levels is {levels!r}; give 'thesis', or pairs of factor and window width") from error
