"""Textures made of neighborhoods in between, by the engine (Ruiters et al. 2010, sections 4.4 and 4.5)."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra import (
    Bags,
    Ballot,
    FreeWindows,
    HardPixels,
    Level,
    Mode,
    Pull,
    Settings,
    SoftPixels,
    TermLike,
    mean,
    optimize,
)
from kwatra.steps.votes import Vote
from synth.metamorphosis.patches.arrangement import Arrangement
from synth.metamorphosis.patches.centers import BestCenters, regular
from synth.metamorphosis.patches.detail import Detail
from synth.metamorphosis.patches.model import Matched
from synth.metamorphosis.patches.relaxation import Relaxed
from synth.metamorphosis.patches.weighting import Weighting


@dataclass(frozen=True)
class Synthesis:
    """How neighborhoods become an image.

    rejected: share of neighborhoods that fit worst and are left out halfway between all textures. iterations: of each
    level. free_centers: windows lie where they fit best in their cell, or else on a grid. relaxed:
    they are shifted until they agree. mean_shift: pixels take the most frequent value, or else the mean, of their
    windows. map_weight: what each texture's weight counts, beside all colors together, where weights differ: more keeps
    a map exactly, less lets the textures decide.
    """

    rejected: float = 0.5
    iterations: int = 3
    free_centers: bool = True
    relaxed: bool = True
    mean_shift: bool = True
    map_weight: float = 2.0

    def __call__(
        self,
        levels: Sequence[Matched],
        weighting: Weighting,
        start: Tensor,
        wrap: bool,
        seed: int,
        detail: Detail,
        kept: Tensor | None = None,
        known: Tensor | None = None,
        wish: SoftPixels | None = None,
    ) -> tuple[Tensor, Arrangement]:
        """The image (C, H, W) of a weighting, and what lies where in it on the last level.

        levels: coarse to fine. start (C + 1, H, W): colors and distance, to be improved. detail: given back after each
        iteration at full resolution. kept (H, W): pixels whose colors stay those of the start, or None.
        known (N, 2): first pixels where windows of the last level are known to fit, or None. wish: what the image is to
        be like, or None: colors and distance, and if weights differ these.
        """
        channels, varied = len(start) - 1, len(weighting.palette) > 1
        bags, numbers = zip(*(_bag(matched, weighting, self.rejected) for matched in levels), strict=True)
        weights = [1 / channels] * channels + [levels[-1].feature_weight]
        if varied:
            weights += [self.map_weight] * len(weighting.values)
            start = torch.cat([start, weighting.values.to(start)])
        last = _Last(Mode() if self.mean_shift else mean)
        settings = Settings(
            levels=tuple(Level(*m.level, self.iterations) for m in levels),
            wrap=wrap,
            vote=Relaxed(last) if self.relaxed else last,
            layout=BestCenters(known) if self.free_centers else regular,
        )
        made = optimize(
            Bags(
                {m.level: bag for m, bag in zip(levels, bags, strict=True)}, torch.tensor(weights, dtype=torch.float32)
            ),
            weighting.shape,
            settings=settings,
            start=start,
            terms=_held(start, channels, kept) + ([] if wish is None else [wish]),
            seed=seed,
            between=detail.between(channels),
        )
        layout, matches = last.ballot.layout, last.ballot.matches
        assert isinstance(layout, FreeWindows)
        return made.image[:channels], Arrangement(levels[-1], layout, numbers[-1][matches])


def _bag(matched: Matched, weighting: Weighting, rejected: float) -> tuple[Tensor, Tensor]:
    """The windows (N, w, w, C + 1) of all weightings that are told apart, and the numbers (N,) of their neighborhoods.

    If there are several, each has further channels that hold its own weights.
    """
    windows, numbers = [], []
    for weights in weighting.palette:
        kept = matched.kept(weights, rejected)
        made = matched.windows(kept, weights)
        if len(weighting.palette) > 1:
            made = torch.cat([made, torch.tensor(weights, dtype=torch.float32).expand(*made.shape[:-1], -1)], -1)
        windows.append(made)
        numbers.append(kept)
    return torch.cat(windows), torch.cat(numbers)


def _held(start: Tensor, channels: int, kept: Tensor | None) -> list[TermLike]:
    """What keeps the weights of a start, after its colors and distance, and the colors of pixels that are kept."""
    fixed = torch.zeros_like(start, dtype=torch.bool)
    fixed[channels + 1 :] = True
    if kept is not None:
        fixed[:channels] |= kept
    return [HardPixels(start, fixed)] if bool(fixed.any()) else []


class _Last:
    """A vote, and what was last voted on."""

    def __init__(self, vote: Vote) -> None:
        self._vote = vote
        self.ballot: Ballot

    def __call__(self, ballot: Ballot) -> Pull:
        self.ballot = ballot
        return self._vote(ballot)
