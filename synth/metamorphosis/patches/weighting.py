"""Which texture in between belongs where: one everywhere, or each pixel its own (Ruiters et al. 2010, section 4.5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import torch
import torch.nn.functional as F
from scipy.ndimage import uniform_filter
from torch import Tensor

from kwatra.base import InputError
from synth.metamorphosis.patches.neighborhoods import Weights
from synth.metamorphosis.patches.pace import Pace

STEPS = 36
"""At most so many weightings are distinguished; of two textures 21, of three 36."""

_OF_TWO = 20
"""Steps from one texture to another, as in the paper."""


@dataclass(frozen=True)
class Weighting:
    """What each texture counts at each pixel.

    values (n, H, W): from 0 to 1, summing to 1. palette: the weightings that are told apart. nearest (H, W): the number
    in the palette of each pixel's.
    """

    values: Tensor
    palette: tuple[Weights, ...]
    nearest: Tensor

    @classmethod
    def even(cls, weights: Weights, shape: tuple[int, int]) -> "Weighting":
        """The same everywhere."""
        values = torch.tensor(weights, dtype=torch.float32).view(-1, 1, 1).expand(-1, *shape)
        return cls(values, (weights,), torch.zeros(shape, dtype=torch.long))

    @classmethod
    def of(cls, values: Tensor) -> "Weighting":
        """Of maps (n, H, W), which are made to sum to 1; InputError for negative, infinite, or empty ones."""
        if values.ndim != 3 or len(values) < 2 or not bool(values.isfinite().all()) or bool((values < 0).any()):
            raise InputError(
                f"the map of weights has shape {tuple(values.shape)}, or values that are negative, NaN or infinite; "
                "give (n, H, W) of weights from 0 on, one channel per texture"
            )
        total = values.sum(0)
        if bool((total <= 0).any()):
            raise InputError("the weights of some pixel are all 0; give at least one texture a weight everywhere")
        values = (values / total).float().cpu()
        flat = values.flatten(1)
        known = torch.tensor(simplex(len(values)), dtype=torch.float32)
        nearest = torch.cat([torch.cdist(part.T, known).argmin(1) for part in flat.split(1 << 16, 1)])
        used, number = nearest.unique(return_inverse=True)
        palette = tuple(tuple(row) for row in known[used].double().tolist())
        return cls(values, palette, number.view(values.shape[1:]))

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.nearest.shape[0], self.nearest.shape[1]

    def paced(self, pace: Pace) -> "Weighting":
        """The weighting of two textures at whose pixels what is in between is as far on its way as the weights say."""
        share = pace.weights(self.values[1])
        if len(self.palette) == 1:
            return Weighting.even((1 - float(share[0, 0]), float(share[0, 0])), self.shape)
        return Weighting.of(torch.stack([1 - share, share]))

    def continued(self, margin: int) -> "Weighting":
        """The same, `margin` pixels further at every border."""
        nearest = continued(self.nearest[None].float(), margin)[0].long()
        return Weighting(continued(self.values, margin), self.palette, nearest)

    @property
    def steepest(self) -> float:
        """The most that a weight changes from one pixel to the next."""
        return max(
            (float(self.values.diff(dim=axis).abs().max()) for axis in (1, 2) if self.shape[axis - 1] > 1), default=0
        )

    @property
    def slope(self) -> float:
        """How much a weight changes from one pixel to the next where most, in the mean over what is of several."""
        several = self.values.amax(0) < 1
        if not several.any() or min(self.shape) < 2:
            return 0.0
        changes = torch.stack(torch.gradient(self.values, dim=(1, 2))).abs().amax((0, 1))
        return float(changes[several].mean())

    def purity(self, reach: int, wrap: bool) -> Tensor:
        """How much of the weight one texture has (1, H, W), in the mean over `reach` px: from 0, as others, to 1, all.

        wrap: the map is periodic.
        """
        mode = "wrap" if wrap else "nearest"
        most = torch.from_numpy(uniform_filter(self.values.numpy(), (0, reach, reach), mode=mode)).amax(0, keepdim=True)
        return ((most * len(self.values) - 1) / (len(self.values) - 1)).clamp(min=0)

    def at(self, corners: Tensor, width: int) -> Tensor:
        """The number in the palette (N,) at the middles of windows with these first pixels (N, 2)."""
        middle = corners + width // 2
        return self.nearest[middle[:, 0] % self.shape[0], middle[:, 1] % self.shape[1]]


def continued(image: Tensor, margin: int) -> Tensor:
    """An image (C, H, W), at every border continued by its mirror image by `margin` pixels, fewer than it has."""
    return F.pad(image[None], (margin,) * 4, "reflect")[0] if margin else image


def cut(image: Tensor, margin: int) -> Tensor:
    """What was continued: an image (C, H, W) without `margin` pixels at every border."""
    rows, columns = (slice(margin, side - margin) for side in image.shape[1:])
    return image[:, rows, columns]


def simplex(count: int) -> list[Weights]:
    """Weightings of `count` textures, evenly spread over all there are, at most STEPS."""
    parts = _OF_TWO if count == 2 else 1
    while count > 2 and len(_compositions(parts + 1, count)) <= STEPS:
        parts += 1
    return [tuple(part / parts for part in each) for each in _compositions(parts, count)]


def checked_weights(weights: Sequence[float], count: int) -> Weights:
    """Weights of so many textures, made to sum to 1; InputError for another number, negative or empty ones."""
    values = tuple(float(weight) for weight in weights)
    if len(values) != count or not all(0 <= value < float("inf") for value in values) or sum(values) == 0:
        raise InputError(
            f"the weights are {', '.join(f'{v:g}' for v in values)}; give {count}, one per texture, from 0 on and not "
            "all 0"
        )
    return tuple(value / sum(values) for value in values)


def _compositions(parts: int, count: int) -> list[tuple[int, ...]]:
    """All ways to deal `parts` equal parts to `count` receivers."""
    bars = combinations(range(parts + count - 1), count - 1)
    ends = ((-1, *bar, parts + count - 1) for bar in bars)
    return [tuple(b - a - 1 for a, b in pairwise(end)) for end in ends]
