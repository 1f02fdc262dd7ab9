"""Derivatives wherever they are asked for: a caller may have switched them off, for good reasons of its own."""

from collections.abc import Iterator
from contextlib import contextmanager

import torch
from torch import Tensor


@contextmanager
def differentiable() -> Iterator[None]:
    """Within it derivatives can be taken, also inside a caller's `torch.no_grad` or `torch.inference_mode`."""
    with torch.inference_mode(False), torch.enable_grad():
        yield


def constant(tensor: Tensor) -> Tensor:
    """A tensor that derivatives may be taken beside, not along: what a caller's inference mode has made is copied."""
    return tensor.clone() if tensor.is_inference() else tensor.detach()
