"""What is copied from: images or videos of one texture, with their holes, variants and pyramid.

All images lie on one canvas, kept apart by gaps. A pixel of the canvas belongs to an image or to nobody; a window
may be copied when all its pixels belong to the same image. Holes, gaps, and the corners that a rotation leaves
empty are then one thing, and the search needs to know of none of them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from kwatra.base import AVERAGE, LARGEST, InputError, device_of, floats_of, mean, running, tensor_of, total
from kwatra.variants import Piece, original, variants

ALIGNMENT = 8
"""Images start at multiples of this on the canvas, so that their pyramids sample them in phase."""

SLIMMEST = 8
"""Of narrower strips little would be left to see or to copy: a guard, not tuned."""


@dataclass(frozen=True)
class Exemplar:
    """A canvas of source images at one resolution; make one with `Exemplar.of`.

    canvas (C, *S) float32. owner (*S) float32: index of the image a pixel belongs to, -1 for nobody. origin
    (1 + n, *S) int64: where the pixel comes from in the images given to `of`, as (image, first axis, ..., last axis)
    in their full-resolution pixels. weights (C,): how much each channel counts in matching. turns (images, 2, 2): what
    takes directions in the images given, x first, y down, to those in the variants on the canvas; None where none is
    mirrored or turned.
    """

    canvas: Tensor
    owner: Tensor
    origin: Tensor
    weights: Tensor
    turns: Tensor | None = None

    @classmethod
    def of(
        cls,
        images: Tensor | Sequence[Tensor],
        *,
        weights: Sequence[float] | None = None,
        masks: Sequence[Tensor | None] | None = None,
        mirror: bool = False,
        rotate: Sequence[float] = (),
        scale: Sequence[float] = (),
        device: torch.device | str | None = None,
    ) -> "Exemplar":
        """An exemplar of one or more images (C, H, W) or videos (C, T, H, W) with the same number of channels.

        masks: per image a boolean (*S), True where texture may be copied from. mirror adds each image flipped along
        its last axis; rotate adds variants turned by so many degrees (counterclockwise); scale adds variants resized by
        these factors. device: where it is to be; None: where the first image is. Raises InputError for empty,
        non-finite or mismatching input.
        """
        images = [tensor_of(image) for image in ([images] if isinstance(images, Tensor) else images)]
        masks = [None] * len(images) if masks is None else [None if m is None else tensor_of(m) for m in masks]
        _check(images, masks)
        device = images[0].device if device is None else device_of(device)
        pieces = list[Piece]()
        for index, (image, mask) in enumerate(zip(images, masks, strict=True)):
            piece = original(image.to(device, torch.float32), mask, index)
            pieces += variants(piece, mirror, rotate, scale)
        channels = images[0].shape[0]
        weight = torch.ones(channels, dtype=torch.float32) if weights is None else floats_of(weights)
        if weight.shape != (channels,) or bool((weight < 0).any()) or not bool(weight.isfinite().all()):
            raise InputError(f"weights are {weights}; give one finite number >= 0 for each of the {channels} channels")
        return _packed(pieces, weight.to(device))

    def to(self, device: torch.device | str) -> "Exemplar":
        """The same exemplar on another device."""
        canvas, owner, origin, weights = (p.to(device) for p in (self.canvas, self.owner, self.origin, self.weights))
        return Exemplar(canvas, owner, origin, weights, None if self.turns is None else self.turns.to(device))

    @property
    def shape(self) -> tuple[int, ...]:
        """Spatial shape of the canvas."""
        return tuple(self.owner.shape)

    @property
    def extent(self) -> tuple[int, ...]:
        """Largest size along each axis of the images it holds as they were given, in this resolution's pixels.

        Of variants nothing is measured: those that are turned are no larger for the corners they leave empty.
        """
        sizes = [inside.shape for _, inside in self.places()]
        return tuple(max(size) for size in zip(*sizes, strict=True))

    @property
    def share(self) -> Tensor:
        """How much each channel counts in matching, (C, 1, ..., 1), sum 1."""
        share = self.weights / self.weights.sum().clamp(min=1e-9)
        return share.view(-1, *[1] * len(self.shape))

    @property
    def variances(self) -> Tensor:
        """The variance of each channel over all that may be copied, (C,)."""
        inside = self.canvas[:, self.owner >= 0]
        return torch.stack([mean((c - mean(c)).square()) for c in inside])

    @property
    def variance(self) -> float:
        """That of all channels together, by their shares."""
        return float(total(self.variances * self.share.flatten()))

    @property
    def alpha(self) -> Tensor | None:
        """How opaque each place of the canvas is, (*S), 0 to 1: the last of two or four channels, where others were
        multiplied by it, so that in the images as they were given none is anywhere larger. None if it is not.
        """
        if len(self.canvas) not in (2, 4):
            return None
        given = (self.canvas[(slice(None), *box)][:, inside] for box, inside in self.places())
        return self.canvas[-1] if all(bool((pixels[:-1] <= pixels[-1]).all()) for pixels in given) else None

    def turned(self, where: Tensor) -> Tensor | None:
        """What takes directions in the images given to those at places (n, *S) of the canvas: (2, 2, *S), x first."""
        if self.turns is None:
            return None
        owner = self.owner[tuple(where)].long().clamp(min=0)
        return self.turns[owner].movedim((-2, -1), (0, 1))

    def places(self) -> Iterator[tuple[tuple[slice, ...], Tensor]]:
        """The boxes on the canvas of the images as they were given, and which pixels of a box are the image's."""
        seen = set()
        for image in range(int(self.owner.max()) + 1):
            inside = self.owner == image
            place = inside.nonzero()
            number = int(self.origin[0][tuple(place[0])]) if len(place) else -1
            if number >= 0 and number not in seen:
                seen.add(number)
                low, high = place.amin(0).tolist(), (place.amax(0) + 1).tolist()
                box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
                yield box, inside[box]

    def pictures(self) -> list[Tensor]:
        """The images on the canvas as they were given, cut out to the bounding boxes of what may be copied."""
        return [self.canvas[(slice(None), *box)] for box, _ in self.places()]

    def coarser(self, factor: Sequence[int]) -> "Exemplar":
        """The exemplar averaged over blocks of `factor` pixels per axis; a block is kept when it is whole.

        It is kept, and with it what is found of it.
        """
        factor = tuple(factor)
        if all(f == 1 for f in factor):
            return self
        if factor not in self._pyramid:
            self._pyramid[factor] = self._averaged(factor)
        return self._pyramid[factor]

    @cached_property
    def _pyramid(self) -> dict[tuple[int, ...], "Exemplar"]:
        return {}

    def halved_to(self, pixels: int) -> tuple["Exemplar", int]:
        """An image's exemplar, its height and width halved until its canvas has at most so many pixels; and how much
        coarser it then is. A strip stays at least `SLIMMEST` pixels wide, and a video as it is.
        """
        if len(self.shape) > 2:
            return self, 1
        factor = 1
        while self.owner.numel() > pixels * factor**2 and min(self.shape) >= 2 * factor * SLIMMEST:
            factor *= 2
        return self.coarser((factor, factor)), factor

    def _averaged(self, factor: tuple[int, ...]) -> "Exemplar":
        average, largest = AVERAGE[len(self.shape)], LARGEST[len(self.shape)]
        high = largest(self.owner[None], factor)[0]
        low = -largest(-self.owner[None], factor)[0]
        every = (slice(None), *(slice(f // 2, f * s, f) for f, s in zip(factor, high.shape, strict=True)))
        owner = torch.where(high == low, high, -1.0)
        return replace(self, canvas=average(self.canvas[None], factor)[0], owner=owner, origin=self.origin[every])

    def corners(self, width: Sequence[int]) -> Tensor:
        """Where windows of `width` may start: boolean, shape S - width + 1."""
        width = tuple(width)
        if any(w > s for w, s in zip(width, self.shape, strict=True)):
            return torch.zeros([0] * len(width), dtype=torch.bool)
        high, low = running(torch.maximum, self.owner, width), running(torch.minimum, self.owner, width)
        return (high == low) & (low >= 0)


def _check(images: Sequence[Tensor], masks: Sequence[Tensor | None]) -> None:
    if not images:
        raise InputError("no exemplar was given; give at least one image")
    if len(masks) != len(images):
        raise InputError(f"{len(masks)} masks were given for {len(images)} images; give one, or None, per image")
    if all(mask is not None and not bool(mask.any()) for mask in masks):
        raise InputError("the exemplar's masks are False everywhere and leave nothing to copy from; leave some True")
    for image, mask in zip(images, masks, strict=True):
        if image.ndim not in (3, 4) or image.ndim != images[0].ndim or 0 in image.shape:
            raise InputError(
                f"an exemplar has shape {tuple(image.shape)}; images are (C, H, W) and videos (C, T, H, W), not empty"
            )
        if image.shape[0] != images[0].shape[0]:
            raise InputError(
                f"exemplars have {images[0].shape[0]} and {image.shape[0]} channels; convert them to the same number"
            )
        if image.dtype.is_floating_point and not bool(image.isfinite().all()):
            raise InputError("an exemplar holds NaN or infinite pixels; replace them")
        if mask is not None and mask.shape != image.shape[1:]:
            raise InputError(
                f"a mask has shape {tuple(mask.shape)} but its image {tuple(image.shape[1:])}; they must be the same"
            )
        if mask is not None and mask.dtype != torch.bool:
            raise InputError(f"an exemplar's mask holds {mask.dtype}; give booleans, True where it may be copied from")


def _packed(pieces: Sequence[Piece], weights: Tensor) -> Exemplar:
    """Lay the pieces out under each other along the next-to-last axis, an alignment's gap or more between them."""
    shape = torch.tensor([p.mask.shape for p in pieces]).amax(0).tolist()
    starts, rows = [], 0
    for piece in pieces:
        starts.append(rows)
        rows += -(-(piece.mask.shape[-2] + ALIGNMENT) // ALIGNMENT) * ALIGNMENT
    shape[-2] = starts[-1] + pieces[-1].mask.shape[-2]
    first = pieces[0]
    canvas = first.image.new_zeros(first.image.shape[0], *shape)
    owner = first.image.new_full(shape, -1.0)
    origin = first.origin.new_zeros(first.origin.shape[0], *shape)
    for index, (piece, start) in enumerate(zip(pieces, starts, strict=True)):
        sides = [slice(0, s) for s in piece.mask.shape]
        sides[-2] = slice(start, start + piece.mask.shape[-2])
        spot = tuple(sides)
        canvas[(slice(None), *spot)] = piece.image
        owner[spot] = torch.where(piece.mask, float(index), -1.0)
        origin[(slice(None), *spot)] = piece.origin
    turns = torch.stack([piece.turn for piece in pieces]).to(canvas.device)
    return Exemplar(canvas, owner, origin, weights, None if bool((turns == torch.eye(2).to(turns)).all()) else turns)
