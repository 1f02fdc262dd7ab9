"""Steps of color from pixel to pixel that are not what they should be where pieces meet, and what corrects them."""

import numpy as np
import torch
from scipy import fft
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import threads_shared
from kwatra.source import look_up

_GUESSED = 1e-6
"""What a step beyond a clip's border, where what changed before is taken to go on, weighs beside one within it."""


def lacking(image: Tensor, where: Tensor, exemplar: Exemplar, axis: int, around: bool) -> Tensor:
    """What steps of an image (C, *S) along an axis, from 1 on, lack: as the source goes on, and as the next's came.

    The map (n, *S) tells where on the exemplar's canvas, of n axes, pixels come from.
    It is the mean of the two, or the one of them that lies within its clip; where neither does, what changed before
    goes on. The axis has as many steps as pixels where it goes `around`, else one less.
    """
    step, n = exemplar.canvas.diff(dim=axis), exemplar.shape[axis - 1] - 1
    before, after = exemplar.owner.narrow(axis - 1, 0, n), exemplar.owner.narrow(axis - 1, 1, n)
    same = (after == before) & (after >= 0)
    none, never = torch.zeros_like(step.narrow(axis, 0, 1)), torch.zeros_like(same.narrow(axis - 1, 0, 1))
    ahead, goes = torch.cat([step, none], axis), torch.cat([same, never], axis - 1)
    back, came = torch.cat([none, step], axis), torch.cat([never, same], axis - 1)
    onward, hither = torch.where(goes, ahead, back * came), torch.where(came, back, ahead * goes)
    last = image.shape[axis] - (not around)
    here, there = (v.narrow(axis, 0, last) for v in (where, where.roll(-1, axis)))
    left, right = (look_up(each[None].float() + _GUESSED, spot) for each, spot in ((goes, here), (came, there)))
    wanted = (left * look_up(onward, here) + right * look_up(hither, there)) / (left + right)
    return wanted - (image.roll(-1, axis) - image).narrow(axis, 0, last)


def corrections(pull: np.ndarray, wrap: tuple[bool, ...], fading: float) -> np.ndarray:
    """The corrections c (..., *S): (D'D + fading) c = pull, with D the steps from pixel to pixel along each axis of S.

    wrap: which of those wrap. Cosines, or along what wraps all waves, are what D'D only scales. Threads share the lines
    of each axis.
    """
    first, threads = pull.ndim - len(wrap), threads_shared()
    sides = [*zip(pull.shape[first:], wrap, strict=True)]
    angles = (2 * np.pi * fft.fftfreq(n) if around else np.pi * np.arange(n) / n for n, around in sides)
    scaled = np.ix_(*((2 - 2 * np.cos(angle)).astype(np.float32) for angle in angles))
    for axis, around in enumerate(wrap, first):
        pull = (fft.fft if around else fft.dct)(pull, axis=axis, overwrite_x=axis > first, workers=threads)
    pull /= sum(scaled, start=np.float32(fading))
    for axis, around in enumerate(wrap, first):
        pull = (fft.ifft if around else fft.idct)(pull, axis=axis, overwrite_x=True, workers=threads)
    return np.real(pull)
