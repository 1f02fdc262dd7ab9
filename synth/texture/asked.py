"""What a texture is asked to be made of, and how large: pictures of one form, a size and a guide that fits them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic

from torch import Tensor

from kwatra import InputError
from kwatra.base import whole_sizes
from synth.texture.form import Form, Image
from synth.texture.guidance import Guide


@dataclass(frozen=True, eq=False)
class Asked(Generic[Image]):
    """The user's images, their form, and the pictures (C, *S) in [0, 1] that they are in it.

    size: the output's, (height, width), of a video with the number of frames before them. guidance: the guide that it
    follows, None without one.
    """

    images: list[Image]
    form: Form[Image]
    pictures: list[Tensor]
    size: tuple[int, ...]
    guidance: Guide | None

    @classmethod
    def of(
        cls, exemplar: Image | Sequence[Image], size: Sequence[int] | None, guide: Any = None, weight: Any = 1.0
    ) -> "Asked[Image]":
        """What is asked by one or several images, a size, and a guide with what it counts; see `synthesize`."""
        images: list[Any] = list(exemplar) if isinstance(exemplar, (list, tuple)) else [exemplar]
        if not images:
            raise InputError("no exemplar was given; give at least one image")
        form: Form[Image] = Form.of(images)
        pictures = [form.normalized(image) for image in images]
        guidance = None if guide is None else Guide.joint(guide, weight, pictures)
        return cls(images, form, pictures, _size(size, pictures[0], guidance), guidance)


def _size(size: Sequence[int] | None, picture: Tensor, guidance: Guide | None) -> tuple[int, ...]:
    """The output's size: as asked, or that of its guide; where both are given they must agree."""
    sides = "height and width" if picture.ndim == 3 else "number of frames, height and width"
    if guidance is None:
        if size is None:
            raise InputError(f"no size was given; give the output's {sides}")
        return whole_sizes(size, picture.ndim - 1, f"the size ({sides})")
    there = tuple(guidance.output.shape[1:])
    asked = there if size is None else whole_sizes(size, picture.ndim - 1, f"the size ({sides})")
    if asked != there:
        raise InputError(f"the size is {asked} but the guide's output map has {there}; leave the size out")
    return there
