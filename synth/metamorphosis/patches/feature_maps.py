"""Binary maps of where a texture has features, found, and the distance to them (Ruiters et al. 2010, section 4.1).

The paper's maps were painted. Here lines are found: dark or bright ridges (gaps, joints, veins), edges, or the outlines
of blobs. Of these the kind is kept that characterizes the texture best: whose windows, where they are alike, lie over
windows of like colors.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter
from skimage.feature import canny
from skimage.filters import apply_hysteresis_threshold, gaussian, threshold_otsu
from skimage.morphology import remove_small_objects, skeletonize
from torch import Tensor

from kwatra.base import InputError

Map = NDArray[np.bool_]

RIDGES = (1.0, 1.5, 2.0)
"""Half widths, in pixels, of the ridges that are looked for: joints and gaps of photographs of 100 to 300 px."""

SHARE = 0.3
"""Part of all pixels that may be ridge before they are thinned to lines. Of .16 to .44, on 22 textures, from .3 on the
joints of stones, tiles and bricks are whole, and with more the maps tell no more of what textures look like."""

REACH = 16.0
"""Distances count up to here, in pixels: half of the largest window."""

_SHORTEST = 8
"""Lines of fewer pixels are specks."""

_WINDOW, _WINDOWS = 17, 400
"""Px of the windows that are paired, and how many are at most: a bound on time."""


def ridge_strength(gray: NDArray[np.float64], half_width: float, dark: bool) -> NDArray[np.float64]:
    """How strongly a dark, or a bright, line of a half width in px runs through each pixel (H, W), from 0 on.

    The largest principal curvature of the blurred image (Sato et al., Three-dimensional multi-scale line filter, 1998;
    `skimage.filters.sato` is the same, but loads scipy.stats, which takes a tenth of a fast still).
    """

    def derived(image: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        order = (1 - axis, axis)
        made: NDArray[np.float64] = gaussian_filter(image, half_width / 2**0.5, order, truncate=8)
        return made

    down, across = derived(gray, 0), derived(gray, 1)
    yy, xy, xx = derived(down, 0), derived(down, 1), derived(across, 1)
    sign = 1 if dark else -1
    curved = sign * (yy + xx) / 2 + np.hypot(xy, (yy - xx) / 2)
    return half_width**2 * np.maximum(curved, 0)


def _ridges(gray: NDArray[np.float64], dark: bool) -> Map:
    strength = np.max([ridge_strength(gray, half_width, dark) for half_width in RIDGES], 0)
    low, high = np.quantile(strength, [1 - SHARE, 1 - SHARE / 3])
    return skeletonize(apply_hysteresis_threshold(strength, max(low, 1e-6), max(high, 1e-6)))


def _edges(gray: NDArray[np.float64]) -> Map:
    return canny(gray, 1.5, 0.7, 0.9, use_quantiles=True)


def _outlines(gray: NDArray[np.float64]) -> Map:
    """The outlines of what is darker, or of what is brighter, after a blur."""
    smooth = gaussian(gray, 1.5)
    inside = smooth > threshold_otsu(smooth) if np.ptp(smooth) > 0 else np.zeros_like(gray, bool)
    eroded = np.pad(inside, 1, mode="edge")
    interior = eroded[:-2, 1:-1] & eroded[2:, 1:-1] & eroded[1:-1, :-2] & eroded[1:-1, 2:]
    return inside & ~interior


KINDS: dict[str, Callable[[NDArray[np.float64]], tuple[Map, ...]]] = {
    "ridges": lambda gray: (_ridges(gray, True), _ridges(gray, False)),
    "edges": lambda gray: (_edges(gray),),
    "blobs": lambda gray: (_outlines(gray),),
}
"""By the name of each kind, its maps of a gray image; ridges are dark or bright ones, whichever suit a texture."""


GIVEN = "given"
"""The kind of maps that were not looked for."""


@dataclass(frozen=True)
class FoundFeatures:
    """Boolean maps (H, W) of several textures, all of one kind; its name.

    sure: how much of what each texture looks like its map tells, 0 to 1.
    """

    maps: tuple[Tensor, ...]
    kind: str
    sure: tuple[float, ...]

    @property
    def remark(self) -> str:
        """A sentence for a person."""
        if self.kind == GIVEN:
            return "features were given"
        return f"features are {self.kind}, which tell {min(self.sure):.0%} of what the textures look like"


def find_features(images: Sequence[Tensor]) -> FoundFeatures:
    """The feature maps of textures (C, H, W), of the kind that characterizes them best together."""
    grays = [image.mean(0).numpy().astype(np.float64) for image in images]
    found = []
    for kind, of in KINDS.items():
        chosen = [
            _best([_cleaned(each) for each in of(gray)], image) for gray, image in zip(grays, images, strict=True)
        ]
        maps, sure = zip(*chosen, strict=True)
        found.append(FoundFeatures(tuple(map(torch.from_numpy, maps)), kind, sure))
    return max(found, key=lambda each: sum(each.sure))


def checked_map(values: Tensor, shape: tuple[int, ...], name: str) -> Tensor:
    """A given map (H, W) or (K, H, W) as booleans, True where any is above a half; InputError for one that is of
    another size, empty, or full.
    """
    where = values.cpu() > 0.5
    where = where.any(0) if where.ndim == 3 else where
    if tuple(where.shape) != tuple(shape):
        raise InputError(f"{name}'s features are {where.shape[1]}x{where.shape[0]} but {name} is {shape[1]}x{shape[0]}")
    if not where.any() or where.all():
        what = "full: every" if where.all() else "empty: no"
        raise InputError(f"{name}'s feature map is {what} pixel is a feature; mark lines or outlines, or leave it out")
    return where


def distance_channel(features: Tensor) -> Tensor:
    """The distance (1, H, W) of each pixel to the nearest feature, in REACH, at most 1; 1 where there is none."""
    if not features.any():
        return torch.ones(1, *features.shape, dtype=torch.float32)
    away = np.minimum(distance_transform_edt(~features.numpy()), REACH) / REACH
    return torch.from_numpy(away)[None].float()


def _cleaned(features: Map) -> Map:
    return np.asarray(remove_small_objects(features, max_size=_SHORTEST - 1, connectivity=2), bool)


def _best(maps: Sequence[Map], image: Tensor) -> tuple[Map, float]:
    sure = [characterizes(torch.from_numpy(features), image) for features in maps]
    return maps[int(np.argmax(sure))], max(sure)


def characterizes(features: Tensor, image: Tensor) -> float:
    """How well a feature map (H, W) tells what the texture (C, H, W) looks like, at most 1; 0 is not at all.

    Windows are paired with those, elsewhere, of the most similar distances; what their colors differ by is compared
    with what those of any two windows do. Windows are 17 px wide, looked at in every second pixel.
    """
    if not features.any():
        return 0.0
    width = min(_WINDOW, *features.shape)
    both = torch.cat([distance_channel(features), image.float()])
    windows = both.unfold(1, width, 2).unfold(2, width, 2)[..., ::2, ::2]
    place = torch.stack(torch.meshgrid(*map(torch.arange, windows.shape[1:3]), indexing="ij"), -1).reshape(-1, 2)
    windows = windows.permute(1, 2, 0, 3, 4).reshape(len(place), len(both), -1)
    pick = torch.randperm(len(place), generator=torch.Generator().manual_seed(0))[:_WINDOWS]
    windows, place = windows[pick], place[pick].float()
    near = torch.cdist(place, place) < width / 4
    by_distance = torch.cdist(windows[:, 0], windows[:, 0]).masked_fill(near, torch.inf)
    colors = torch.cdist(windows[:, 1:].flatten(1), windows[:, 1:].flatten(1)).square()
    usual = float(colors[~near].mean()) if bool((~near).any()) else 0.0
    if usual == 0 or not bool(by_distance.isfinite().any()):
        return 0.0
    least, partner = by_distance.min(1)
    alike = colors.gather(1, partner[:, None])[:, 0][least.isfinite()]
    return max(1 - float(alike.mean()) / usual, 0.0)
