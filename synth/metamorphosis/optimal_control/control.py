"""Texture metamorphosis by optimal control (Kabul et al. 2011, algorithms 1 and 2).

Finds the velocity of least energy (`energy`), coarse to fine, and shows the pictures along it (`film`). Colors are
compared with mean and deviation made alike: that all of a texture changes color is no reason to move. Features that A
and B are known to share, or that are found, are matched beside the colors.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from kwatra.base import InputError, mean
from synth.metamorphosis.features import FOUND
from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.optimal_control.energy import Change
from synth.metamorphosis.optimal_control.film import frames
from synth.metamorphosis.velocity import PRESETS as SEARCHES
from synth.metamorphosis.velocity import Search


@dataclass(frozen=True)
class Control(Method):
    """Metamorphosis by optimal control.

    search: for the velocity, among colors of deviation 1. sigma: how far features may be from matching, in their
    deviations; the smaller the more they count; tuned on the pairs of `Search`. find: features beside those of the
    pair, one of features.FOUND; on those pairs edges did not help.
    """

    search: Search = field(default_factory=Search)
    sigma: float = 1.0
    find: str = "none"

    def __post_init__(self) -> None:
        if not (0 < self.sigma < float("inf")):
            raise InputError(f"sigma is {self.sigma}; give a finite number above 0")
        if self.find not in FOUND:
            raise InputError(f"find is {self.find!r}; allowed are {', '.join(FOUND)}")

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """See `synth.metamorphosis.method.Method`; the velocity is the same for any seed."""
        colors = torch.stack([_standardized(pair.a), _standardized(pair.b)])
        images = torch.cat([colors, *self._features(pair)], 1)
        lack = self._lack(colors.shape[1], pair.tile)
        found = self.search.velocity(images, lack, pair.tile, report)
        pictures = Frames(frames(found.velocity, pair.a, pair.b, times, pair.tile), len(times))
        remarks = (found.stopped, f"no map folds, the least Jacobian is {found.least:.2f}")
        return Film(pictures, tuple(times), found.velocity, found.energies, remarks)

    def _lack(self, colors: int, wrap: bool) -> Callable[[Tensor], Change]:
        return lambda images: Change(images, colors, self.sigma, wrap)

    def _features(self, pair: Pair) -> list[Tensor]:
        """Features (2, K, H, W) of A and B, given and found, each with deviation 1."""
        features = []
        if pair.features_a is not None and pair.features_b is not None:
            features.append(torch.stack([_standardized(pair.features_a), _standardized(pair.features_b)]))
        if self.find != "none":
            features.append(torch.stack([_standardized(FOUND[self.find](image)) for image in (pair.a, pair.b)]))
        return features


PRESETS = {name: Control(search) for name, search in SEARCHES.items()}


def _standardized(image: Tensor) -> Tensor:
    """An image (C, H, W) with mean 0 in each channel and deviation 1 over all; 0 where it is all one color."""
    centered = torch.stack([channel - mean(channel) for channel in image])
    return centered / mean(centered.square()).sqrt().clamp(min=1e-4)
