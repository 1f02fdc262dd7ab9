"""Texton masks: where a texture's elements are (Tonietto and Walter 2005, 3.1)."""

import math

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kwatra.base import InputError
from synth.metamorphosis.elements import SPECK, elements, labeled, two_colors, without_specks

Color = tuple[float, ...]
Mask = NDArray[np.bool_]


def colored(image: Tensor, foreground: Color, background: Color, tolerance: float = 0.0) -> Mask:
    """The mask (H, W) of an image (C, H, W): True where it is nearer to the foreground's color than the background's.

    Colors have C values, as the image has them, or one for all channels. tolerance: by so much nearer may the
    background be.

    Raises InputError for colors of another number of values, NaN or infinite, or alike.
    """
    for color in (foreground, background):
        if len(color) not in (1, len(image)) or not all(math.isfinite(value) for value in color):
            raise InputError(f"the color {tuple(color)} is no color of {len(image)} finite values; give one")
    if tuple(foreground) == tuple(background):
        raise InputError(f"foreground and background are both {tuple(foreground)}; give two colors")
    away = [
        (image - torch.tensor(color, dtype=torch.float32).view(-1, 1, 1)).norm(dim=0)
        for color in (foreground, background)
    ]
    return np.asarray((away[0] <= away[1] + tolerance).numpy())


def checked(mask: Mask, image: Tensor, name: str) -> Mask:
    """A mask (H, W) without specks, its elements parted.

    Raises InputError if it is not of its image's size, or has elements everywhere or nowhere.
    """
    if mask.shape != tuple(image.shape[1:]):
        raise InputError(
            f"the mask of {name} is {mask.shape[1]}x{mask.shape[0]} but {name} {image.shape[2]}x{image.shape[1]}; "
            "give one of its size"
        )
    cleaned = labeled(without_specks(mask)) > 0
    if mask.all() or not cleaned.any():
        raise InputError(
            f"the mask of {name} is {'all' if mask.all() else 'no'} foreground, but for specks of less than {SPECK} "
            "px; give a mask or colors that part its elements from their ground"
        )
    return cleaned


def found(image: Tensor) -> Mask:
    """The mask (H, W) of an image (C, H, W): its elements, or where it shows none the smaller of two color clusters."""
    pixels = image.permute(1, 2, 0).double().numpy()
    split = elements(pixels)
    return split.mask if split.count else two_colors(pixels)
