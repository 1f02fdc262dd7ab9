"""The kinds of image and video that users have, of any dtype and range, and the engine's: [0, 1] float."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

from kwatra import InputError
from kwatra.base import tensor_of
from kwatra.source import CHUNK

Image = TypeVar("Image", Tensor, np.ndarray)


@dataclass(frozen=True)
class Form(Generic[Image]):
    """The kind of image the user gave, and the affine map of its values to [0, 1]: `Form.of` images of one kind.

    sizes: the height and width of each, of a video with the number of frames before them.
    """

    tensor: bool
    flat: bool
    dtype: torch.dtype | np.dtype
    low: float
    high: float
    sizes: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, images: Sequence[Image], what: str = "an exemplar") -> "Form[Image]":
        """The form of images of one kind, from the least to the largest of their values; InputError for others.

        what: what sentences call them.
        """
        first = images[0]
        low, high = float("inf"), float("-inf")
        for image in images:
            _check(image, first, what)
            values = tensor_of(image).double()
            if not bool(values.isfinite().all()):
                raise InputError(f"{what} holds NaN or infinite pixels; replace them first")
            low, high = min(low, float(values.min())), max(high, float(values.max()))
        return cls(isinstance(first, Tensor), first.ndim == 2, first.dtype, low, high, tuple(map(size_of, images)))

    @property
    def black(self) -> float:
        """What normalized values lack of being in proportion to the user's; 0 where those go below 0."""
        return max(self.low, 0.0) / ((self.high - self.low) or 1.0)

    def normalized(self, image: Image) -> Tensor:
        """As a float tensor (C, H, W), or (C, T, H, W), with values in [0, 1]."""
        values = tensor_of(image).double()
        if not self.tensor:
            values = values[None] if self.flat else values.movedim(-1, 0)
        return ((values - self.low) / ((self.high - self.low) or 1.0)).float().contiguous()

    def converted(self, image: Tensor, other: "Form[Image]") -> Tensor:
        """An image that another form normalized, normalized by this one."""
        values = image.double() * (other.high - other.low) + (other.low - self.low)
        return (values.clamp(other.low - self.low, other.high - self.low) / ((self.high - self.low) or 1.0)).float()

    def restored(self, image: Tensor) -> Image:
        """The inverse of `normalized`, in the user's kind and dtype. Memory: the result, and a part in doubles."""
        rows = max(CHUNK * image.shape[-2] // image.numel(), 1)
        parts = [self._restored(part) for part in image.split(rows, -2)]
        made: Any = torch.cat(parts, -2) if self.tensor else np.concatenate(parts, -2 if self.flat else -3)
        return made

    def _restored(self, image: Tensor) -> Any:
        values: Any = image.to(torch.float64, copy=True)
        values.mul_(self.high - self.low).add_(self.low).clamp_(self.low, self.high)
        if isinstance(self.dtype, torch.dtype):
            return (values if self.dtype.is_floating_point else values.round_()).to(self.dtype)
        values = values if np.issubdtype(self.dtype, np.floating) else values.round_()
        return (values[0] if self.flat else values.movedim(0, -1)).numpy().astype(self.dtype, order="C")


def size_of(image: Tensor | np.ndarray) -> tuple[int, ...]:
    """The height and width of a user's image, of a video with the number of frames before them."""
    return tuple(image.shape[1:] if isinstance(image, Tensor) else image.shape[: max(image.ndim - 1, 2)])


def map_like(image: Image, values: np.ndarray) -> Image:
    """A map of values (*S) in one channel, of the kind of a user's image: a tensor (1, *S) or an array (*S, 1)."""
    made: Any = tensor_of(values)[None] if isinstance(image, Tensor) else values[..., None]
    return made


def _check(image: Any, first: Any, what: str) -> None:
    """Refuse what is no image, or not of the first one's kind."""
    shape = f" of shape {tuple(image.shape)}" if isinstance(image, (Tensor, np.ndarray)) else ""
    wanted = (3, 4) if isinstance(image, Tensor) else (2, 3, 4)
    alike = type(image) is type(first) and (not shape or (image.ndim == 4) == (first.ndim == 4))
    if not alike or not shape or image.ndim not in wanted or 0 in image.shape:
        raise InputError(
            f"{what} is a {type(image).__name__}{shape}; give tensors (C, H, W), or arrays (H, W) or (H, W, C), "
            "or for videos (C, T, H, W) or (T, H, W, C), all of one kind and not empty"
        )
    if _numbers(image) != _numbers(first):
        raise InputError(
            f"{what} holds {image.dtype} but another {first.dtype}; give all of one type, whose values mean the same"
        )


def _numbers(image: Any) -> str:
    """The type of an image's numbers; all floating point is one."""
    if isinstance(image, Tensor):
        return "float" if image.is_floating_point() else str(image.dtype)
    return "float" if image.dtype.kind == "f" else str(image.dtype.newbyteorder("="))
