"""Guidance: maps of the exemplar and of the output that say which part of the texture belongs where.

Texture by numbers (labels), or any quantity that the texture varies with: a density, a distance, an orientation. The
maps are further channels of exemplar and output: windows match on them too, and the output's are hard pixels.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from kwatra import (
    Charge,
    Exemplar,
    HardPixels,
    InputError,
    PlaceCharge,
    Quadratic,
    Settings,
    Step,
    Sum,
    Term,
    TermLike,
    planned_levels,
)
from kwatra.levels import finishing
from kwatra.pieces import hidden_seams
from kwatra.terms import charge_of, parts_of, place_charge_of, within
from synth.texture.form import Form

Terms = TermLike | Sum | Sequence[TermLike | Sum]

BLOCK = 0.2
"""Size of a guided start's blocks as a share of the exemplar: small ones follow the guide, large ones the texture.

Of three pairs of photographs in one (brick and grass, rocks and bricks, onyx and radishes) .88 of the pixels follow the
labels, at a score of .195; .89 and .209 with .1, .86 and .162 with .4."""

BLOCK_OF_ELEMENTS = 0.4
"""The same where seams are hidden between elements: over these, smaller ones are laid where they miss the guide, and
the last level alone is done after. Of made tiles, stones, coins and letters of 20 and 48 pixels, with a gradient that
is to run round a center (weight .3, two seeds), .34 of the elements are cut where .65 were, and they are off by .063 of
it where they were by .060. Where there are no gaps this shows ramps 1.3 times as steep as they are wanted."""


@dataclass(frozen=True)
class Guide:
    """Guide channels in [0, 1]: one map (G, H, W) for each exemplar, one for the output, and what they count.

    weight: how much all of a guide's channels count beside all of the image's; or how much each of them does.
    """

    exemplars: list[Tensor]
    output: Tensor
    weight: float | tuple[float, ...]

    @classmethod
    def joint(cls, guides: Any, weight: float | Sequence[float], images: Sequence[Tensor]) -> "Guide":
        """As `of`; or, from a list of guides, all of them as one, with one weight for all or one for each."""
        if not isinstance(guides, list) or not all(isinstance(guide, tuple) for guide in guides):
            return cls.of(guides, weight, images)
        weights = list(weight) if isinstance(weight, (list, tuple)) else [weight] * len(guides)
        if not guides or len(weights) != len(guides):
            raise InputError(f"there are {len(guides)} guides but {len(weights)} weights; give one weight, or one each")
        parts = [cls.of(guide, each, images) for guide, each in zip(guides, weights, strict=True)]
        for part in parts:
            if part.output.shape[1:] != parts[0].output.shape[1:]:
                raise InputError(f"the guides' output maps are {_size(parts[0].output)} and {_size(part.output)}; "
                                 "give all the output's size")  # fmt: skip
        exemplars = [torch.cat([part.exemplars[number] for part in parts]) for number in range(len(images))]
        counts = tuple(count for part in parts for count in part.counts)
        return cls(exemplars, torch.cat([part.output for part in parts]), counts)

    @classmethod
    def of(cls, guide: tuple[Any, Any], weight: Any, images: Sequence[Tensor]) -> "Guide":
        """From (exemplar's map or maps, output's map), of one kind, for exemplar images (C, H, W)."""
        if len(guide) != 2:
            raise InputError(f"the guide has {len(guide)} parts; give the exemplar's map and the output's")
        if not isinstance(weight, (int, float)) or not 0 < weight < float("inf"):
            raise InputError(f"the guide's weight is {weight}; it is finite and > 0")
        maps = list(guide[0]) if isinstance(guide[0], (list, tuple)) else [guide[0]]
        if len(maps) != len(images):
            raise InputError(f"the guide has {len(maps)} maps for {len(images)} exemplars; give one for each")
        form: Form[Any] = Form.of([*maps, guide[1]], "a guide's map")
        if len({each.ndim for each in (*maps, guide[1])}) > 1:
            raise InputError(
                "the guide's maps differ in their number of axes; give all as (H, W), or all with channels"
            )
        exemplars, output = [form.normalized(each) for each in maps], form.normalized(guide[1])
        for each, image in zip(exemplars, images, strict=True):
            if each.shape[1:] != image.shape[1:]:
                raise InputError(
                    f"a guide's map is {_size(each)} but its exemplar {_size(image)}; it has its exemplar's size"
                )
            if len(each) != len(output):
                raise InputError(
                    f"the guide's maps have {len(each)} and {len(output)} channels; give them the same number"
                )
        return cls(exemplars, output, weight)

    @property
    def counts(self) -> tuple[float, ...]:
        """What each channel counts beside all of the image's."""
        own = len(self.output)
        return self.weight if isinstance(self.weight, tuple) else (self.weight / own,) * own

    def weights(self, channels: int) -> list[float]:
        """The weights of all channels of a guided image."""
        return [1.0] * channels + [count * channels for count in self.counts]

    def joined(self, images: Sequence[Tensor]) -> list[Tensor]:
        """The exemplar images with their guide channels."""
        return [torch.cat([image, guide]) for image, guide in zip(images, self.exemplars, strict=True)]

    def beside(self, image: Tensor) -> Tensor:
        """An image of the output with the output's guide channels."""
        return torch.cat([image, self.output.to(image.device)])

    def terms(self, others: Terms, channels: int, device: str) -> list[TermLike]:
        """Terms for the image's channels, and the guide: hard pixels of its own channels.

        What the guide counts is in the channels' weights, so it needs no further weight in the search.
        """
        target = self.beside(torch.zeros(channels, *self.output.shape[1:], dtype=torch.float32)).to(device)
        where = torch.arange(len(target), device=device).view(-1, *[1] * (target.ndim - 1)) >= channels
        guide = HardPixels(target, where.expand_as(target), weight=0.0, label="guide")
        return [*(OnImage(term, channels) for term in parts_of(others)), guide]

    def settings(self, settings: Settings, pictures: Sequence[Tensor], size: Sequence[int]) -> Settings:
        """Settings that suit a guide: its blocks, and levels planned without it."""
        exemplar = Exemplar.of(list(pictures))
        of_elements = len(size) == 2 and hidden_seams(exemplar) is not None
        levels = settings.levels
        if levels is None:
            planned = planned_levels(exemplar, size, settings.iterations)
            levels = finishing(planned) if of_elements else planned
        return replace(settings, levels=levels, block=BLOCK_OF_ELEMENTS if of_elements else BLOCK)


@dataclass(frozen=True)
class OnImage(Term):
    """A term for the first `channels` of an image that has guide channels too."""

    term: TermLike
    channels: int

    @property
    def name(self) -> str:
        """The inner term's name."""
        return self.term.name

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "OnImage":
        """See `Term.at`."""
        return OnImage(self.term.at(factor, shape), self.channels)

    def within(self, mask: Tensor) -> "OnImage":
        """See `Term.within`."""
        return OnImage(within(self.term, mask), self.channels)

    def energy(self, x: Tensor) -> float:
        """The inner term's energy of the image without its guide."""
        return self.term.energy(x[: self.channels])

    def charge(self, x: Tensor | None, step: Step) -> Charge | None:
        """What the inner term charges windows without their guide."""
        inner = charge_of(self.term, None if x is None else x[: self.channels], step)
        if inner is None:
            return None
        return lambda corners, windows: inner(corners, windows[..., : self.channels])

    def place_charge(self, exemplar: Exemplar, shape: tuple[int, ...], width: tuple[int, ...]) -> PlaceCharge | None:
        """What the inner term charges for places."""
        return place_charge_of(self.term, exemplar, shape, width)

    def quadratic(self, x: Tensor) -> Quadratic:
        """The inner quadratic, 0 on the guide."""
        image = x[: self.channels]
        inner, rest = self.term.quadratic(image), torch.zeros_like(x[self.channels :])

        def widened(part: Tensor) -> Tensor:
            return torch.cat([part.expand(len(image), *part.shape[1:]), rest])

        fixed = None if inner.fixed is None else widened(inner.fixed.float()) > 0
        apply: Callable[[Tensor], Tensor] | None = None
        if inner.apply is not None:
            apply = _Widened(inner.apply, self.channels)
        return Quadratic(widened(inner.diagonal), widened(inner.target), apply, fixed)


@dataclass(frozen=True)
class _Widened:
    apply: Callable[[Tensor], Tensor]
    channels: int

    def __call__(self, x: Tensor) -> Tensor:
        return torch.cat([self.apply(x[: self.channels]), torch.zeros_like(x[self.channels :])])


def _size(image: Tensor) -> str:
    return "x".join(map(str, image.shape[:0:-1]))
