"""Merging images along the best seam (thesis section 3.4 B, figures 12 to 14).

The background is laid down, then each overlay in turn, constrained by drawings: pixels that must come from the overlay,
pixels that must stay, and the rim of the overlay where it ends inside the background. The cut does the rest: it runs
where the images are alike, or, with cost M', along edges that hide it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError, floats_of, tensor_of
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting.synthesis import Quilt, QuiltSettings, result_of


@dataclass(frozen=True)
class Overlay:
    """An image (C, H, W) to merge in, its top left pixel at column `x`, row `y` of the background.

    `keep`: boolean (H, W), pixels that must come from it. `spare`: boolean (H, W) or None, pixels of it that must not
    be used. `at` may lie outside the background; only what overlaps counts.
    """

    image: Tensor
    at: tuple[int, int]
    keep: Tensor
    spare: Tensor | None = None


def merge(background: Tensor, overlays: Sequence[Overlay], settings: QuiltSettings | None = None) -> Quilt:
    """Merge overlays into a background (C, H, W), in order; later ones may cover earlier ones but for what they keep.

    Of the settings the cost and the blending are used. In the result, `source` is 0 for the background and n for the
    n-th overlay. Raises InputError if an overlay does not overlap the background, its kept pixels do not or are none,
    or what it must keep and what must stay contradict each other.
    """
    settings = settings or QuiltSettings(normalized=True)
    background, overlays = floats_of(background).cpu(), [_plain(overlay) for overlay in overlays]
    for number, overlay in enumerate(overlays, 1):
        _check(background, overlay, f"overlay {number}")
    sources = Mosaic([background.numpy(), *(o.image.numpy() for o in overlays)])
    shape = tuple(background.shape[1:])
    sheet = Sheet(sources, shape, (False, False), settings.cost_of(sources))
    sheet.lay(Patch(0, (0, 0), Box((0, 0), shape)))
    for number, overlay in enumerate(overlays, 1):
        _lay(sheet, number, overlay)
    return result_of(sheet, settings, [sheet.total], f"{len(overlays)} overlays were merged")


def _plain(overlay: Overlay) -> Overlay:
    """The same as numbers of the engine, on the CPU."""
    spare = None if overlay.spare is None else tensor_of(overlay.spare).cpu()
    return replace(overlay, image=floats_of(overlay.image).cpu(), keep=tensor_of(overlay.keep).cpu(), spare=spare)


def _check(background: Tensor, overlay: Overlay, name: str) -> None:
    image = overlay.image
    if image.ndim != 3 or image.shape[0] != background.shape[0]:
        raise InputError(
            f"{name} has shape {tuple(image.shape)} but the background has {background.shape[0]} channels; convert one"
        )
    for word, mask in (("keep", overlay.keep), ("spare", overlay.spare)):
        if mask is None:
            continue
        if mask.ndim != 2 or mask.dtype != torch.bool:
            raise InputError(
                f"the {word} mask of {name} has shape {tuple(mask.shape)} and type {mask.dtype}; give booleans (H, W)"
            )
        if mask.shape != image.shape[1:]:
            high, wide = mask.shape
            raise InputError(
                f"the {word} mask of {name} is {wide}x{high} but the overlay is {image.shape[2]}x{image.shape[1]}; "
                "draw it at the overlay's size"
            )
    if not bool(torch.isfinite(image).all() and torch.isfinite(background).all()):
        raise InputError(f"{name} or the background has NaN or infinite values; replace them by finite ones")
    if not bool(overlay.keep.any()):
        raise InputError(f"the keep mask of {name} is empty; mark at least one pixel that must come from it")
    if overlay.spare is not None and bool((overlay.keep & overlay.spare).any()):
        both = int((overlay.keep & overlay.spare).sum())
        raise InputError(f"{both} pixels of {name} are both to be kept and to be spared; a pixel can be only one")


def _lay(sheet: Sheet[Mosaic], number: int, overlay: Overlay) -> None:
    shift = (overlay.at[1], overlay.at[0])
    box = Box(shift, tuple(overlay.image.shape[1:])).clipped(sheet.shape, (False, False))
    if min(box.extent) == 0:
        raise InputError(
            f"overlay {number} at {overlay.at[0]},{overlay.at[1]} does not overlap the background of "
            f"{sheet.shape[1]}x{sheet.shape[0]}; move it"
        )
    inner = tuple(slice(s - t, s - t + e) for s, e, t in zip(box.start, box.extent, shift, strict=True))
    keep = overlay.keep.numpy()[inner]
    if not keep.any():
        raise InputError(f"no kept pixel of overlay {number} lies on the background; move it or its mask")
    at = sheet.indices(box)
    taken = int((sheet.fixed[at] & keep).sum())
    if taken:
        raise InputError(
            f"{taken} pixels that overlay {number} must keep are kept by an earlier one; separate the masks"
        )
    stay = _rim(sheet.shape, box)
    if overlay.spare is not None:
        stay |= overlay.spare.numpy()[inner]
    sheet.lay(Patch(number, shift, box), must=keep, must_not=stay & ~keep)
    sheet.fixed[at] |= keep


def _rim(shape: tuple[int, ...], box: Box) -> np.ndarray:
    """The outermost pixels of the box, but where it ends with the background itself."""
    rim = np.zeros(box.extent, bool)
    for axis, (start, stop, count) in enumerate(zip(box.start, box.stop, shape, strict=True)):
        line = np.moveaxis(rim, axis, 0)
        line[0] |= start > 0
        line[-1] |= stop < count
    return rim
