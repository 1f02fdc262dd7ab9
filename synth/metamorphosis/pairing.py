"""Two textures made alike: the same channels, the same range, the same size, or any size, synthesized."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from kwatra.base import InputError, tensor_of
from synth.metamorphosis.features import blobs
from synth.metamorphosis.method import Pair, Report
from synth.texture.form import Form
from synth.texture.images import synthesize

_FOUND_GUIDE = 0.1
"""What found features count beside the colors when B is synthesized to lie where A does; given ones count 1."""


def alike(a: Any, b: Any) -> tuple[Any, Any, list[str]]:
    """Two images of one kind (arrays or tensors) with the channels of the one that has more, and what was done.

    Gray becomes color by repeating it. InputError where channels cannot be made alike.
    """
    counts = [_channels(image) for image in (a, b)]
    if counts[0] == counts[1]:
        return a, b, []
    if min(counts) != 1 or max(counts) != 3:
        raise InputError(
            f"A has {counts[0]} channels and B {counts[1]}; give both the same, or one of them gray and the other color"
        )
    gray = "A" if counts[0] == 1 else "B"
    return _colored(a), _colored(b), [f"{gray} is gray and was made color like the other"]


@dataclass(frozen=True)
class Given:
    """A pair as it was given, made alike; the form of its images, which leads back; what was done to them."""

    pair: Pair
    form: Form[Any]
    remarks: tuple[str, ...]

    @classmethod
    def of(cls, a: Any, b: Any, features: Sequence[Any] | None, tile: bool, least: int) -> "Given":
        """Two images of one kind; the larger is cropped to the size of the smaller, at the right and at the bottom.

        least: px that both must have along each side.
        """
        Form.of([a, b])  # says what is no image, before channels are counted
        if a.ndim == 4:
            raise InputError("A and B are videos; give images")
        a, b, done = alike(a, b)
        form: Form[Any] = Form.of([a, b])
        first, second = form.normalized(a), form.normalized(b)
        masks = (None, None) if features is None else _masks(features, first, second)
        height, width = (min(p, q) for p, q in zip(first.shape[1:], second.shape[1:], strict=True))
        if min(height, width) < least:
            raise InputError(f"A and B have {width}x{height} px in common; give textures of at least {least}x{least}")
        if first.shape != second.shape:
            done = [*done, f"A is {_size(first)} and B {_size(second)}, both were cropped to {width}x{height}"]
        cropped = [None if t is None else t[:, :height, :width].contiguous() for t in (first, second, *masks)]
        assert cropped[0] is not None
        assert cropped[1] is not None
        pair = Pair(cropped[0], cropped[1], cropped[2], cropped[3], tile, (form.low, form.high))
        return cls(pair, form, tuple(done))


@dataclass(frozen=True)
class Growth:
    """How to synthesize a pair at another size: see `synthesize`."""

    preset: str
    seed: int
    device: str

    def __call__(self, pair: Pair, size: tuple[int, int], report: Report) -> Pair:
        """A at the size (height, width), and B with its features where A's then lie.

        The features are the pair's, or else blobs that are found.
        """
        if pair.features_a is None or pair.features_b is None:
            features, weight = (_ranked(blobs(pair.a)), _ranked(blobs(pair.b))), _FOUND_GUIDE
        else:
            features, weight = (pair.features_a, pair.features_b), 1.0
        common: dict[str, Any] = {"preset": self.preset, "seed": self.seed, "tile": pair.tile, "device": self.device}
        a = synthesize(pair.a, size, callback=lambda p: report("synthesizing A", p.fraction / 2), **common)
        guide = (features[1], a.take(features[0]))
        b = synthesize(
            pair.b,
            size,
            guide=guide,
            guide_weight=weight,
            callback=lambda p: report("synthesizing B where A's features lie", (1 + p.fraction) / 2),
            **common,
        )
        grown = replace(pair, a=a.image, b=b.image)
        if pair.features_a is None or pair.features_b is None:
            return grown
        return replace(grown, features_a=a.take(pair.features_a), features_b=b.take(pair.features_b))


def _ranked(features: Tensor) -> Tensor:
    """Each channel's values replaced by their rank, 0 to 1: two textures' features then have one distribution."""
    ranks = [channel.flatten().argsort(stable=True).argsort(stable=True).view_as(channel) for channel in features]
    return torch.stack(ranks).float() / max(features[0].numel() - 1, 1)


def _masks(features: Sequence[Any], a: Tensor, b: Tensor) -> tuple[Tensor, Tensor]:
    if len(features) != 2:
        raise InputError(f"{len(features)} maps of features were given; give A's and B's")
    masks = []
    for name, mask, image in zip("AB", features, (a, b), strict=True):
        values = tensor_of(mask).float()
        values = values[None] if values.ndim == 2 else values
        if values.ndim != 3 or values.shape[1:] != image.shape[1:]:
            raise InputError(
                f"{name}'s features have shape {tuple(values.shape)}, but {name} is {_size(image)}; give (H, W) or "
                "(K, H, W) of the same size"
            )
        if not bool(values.isfinite().all()):
            raise InputError(f"{name}'s features hold NaN or infinite values; replace them first")
        masks.append(values)
    if len(masks[0]) != len(masks[1]):
        raise InputError(f"A has {len(masks[0])} maps of features and B {len(masks[1])}; give the same number")
    return masks[0], masks[1]


def _channels(image: Any) -> int:
    if image.ndim == 2:
        return 1
    return int(image.shape[0] if isinstance(image, Tensor) else image.shape[-1])


def _colored(image: Any) -> Any:
    if _channels(image) == 3:
        return image
    if isinstance(image, Tensor):
        return image.expand(3, -1, -1)
    return (image[..., None] if image.ndim == 2 else image).repeat(3, -1)


def _size(image: Tensor) -> str:
    return f"{image.shape[2]}x{image.shape[1]}"
