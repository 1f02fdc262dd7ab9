"""`morph`: the one door to all metamorphoses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np

from kwatra.base import InputError, device_of, whole_sizes
from synth.metamorphosis.method import Film, Frames, Report, silent
from synth.metamorphosis.methods import DEFAULT, entry, refuse_unused
from synth.metamorphosis.methods import method as method_of
from synth.metamorphosis.pairing import Given, Growth
from synth.metamorphosis.retexture import PRESETS as RETEXTURE
from synth.texture.form import Form, Image


@dataclass(frozen=True)
class Metamorphosis(Generic[Image]):
    """A film from one texture to another.

    frames: one image per time, of the kind of A and B. film: what the method returned, its frames normalized to
    [0, 1]; its `form` leads back. remarks: sentences on what was done, such as made alike.
    """

    frames: Sequence[Image]
    film: Film
    form: Form[Image]
    remarks: tuple[str, ...]

    @property
    def times(self) -> tuple[float, ...]:
        """The time of each frame, 0 (A) to 1 (B)."""
        return self.film.times


def morph(
    a: Image,
    b: Image,
    times: int | Sequence[float] = 11,
    *,
    method: str = DEFAULT,
    size: tuple[int, int] | None = None,
    features: tuple[Any, Any] | None = None,
    tile: bool = False,
    retexture: bool = False,
    preset: str = "default",
    seed: int = 0,
    device: str = "cpu",
    callback: Report | None = None,
    **options: Any,
) -> Metamorphosis[Image]:
    """The frames of a metamorphosis from A to B, in each of which there is a good texture.

    a, b: images of one kind: tensors (C, H, W), or arrays (H, W) or (H, W, C), floating point in any range or
    integer; gray and color are made alike, and both are cropped to what they have in common. times: of the frames, 0
    to 1, or how many evenly from A to B, at least 2. method: one of `methods.METHODS`; options: its own settings. size:
    (height, width) of the frames; A and B are synthesized at that size first. features: maps (H, W) or (K, H, W) of A
    and B that say where their features are, for methods that look at them. tile: A and B repeat seamlessly in both
    directions, and so do the frames. retexture: what the method shows is made texture again, frame by frame. preset:
    "fast", "default" or "best". device: where A and B are synthesized, and control, registration and blend
    computed; the other methods, loops and searches, run on the CPU. callback: told what is being done, and how much of
    it is.

    Same seed, same bits, for any number of threads. Raises InputError for what cannot be used.
    """
    made = begun(
        a, b, times, method=method, size=size, features=features, tile=tile, retexture=retexture, preset=preset,
        seed=seed, device=device, callback=callback, **options,
    )  # fmt: skip
    return replace(made, frames=list(made.frames))


def begun(
    a: Image,
    b: Image,
    times: int | Sequence[float],
    *,
    method: str,
    size: tuple[int, int] | None,
    features: tuple[Any, Any] | None,
    tile: bool,
    retexture: bool,
    preset: str,
    seed: int,
    device: str,
    callback: Report | None,
    **options: Any,
) -> Metamorphosis[Image]:
    """As `morph`, but frames are made one by one as they are first looked at, so that they can be kept meanwhile."""
    moments = _times(times)
    known, about = method_of(method, preset, options), entry(method)
    refuse_unused(method, "features", features is not None)
    refuse_unused(method, "tile", tile)
    report = callback or silent
    given: Given = Given.of(a, b, features, tile, about.least)
    pair = given.pair
    sized = None if size is None else known.of_size(_checked(size, about.least))
    parts = _shares(report, (size is not None and sized is None, 3.0), (True, 4.0), (retexture, 6.0))
    if size is not None and sized is None:
        pair = Growth(preset, seed, device)(pair, size, parts[0])
    pair = pair.to(device_of(device) if about.anywhere else "cpu")
    film: Film = (sized or known)(pair, moments, seed, parts[1])
    if retexture:
        film = RETEXTURE[preset](pair, film, seed, parts[2])
    shown = (given.form.restored(frame.cpu()) for frame in film.frames)
    frames = Frames(shown, len(moments))
    return Metamorphosis(frames, film, given.form, (*given.remarks, *film.remarks))


def _times(times: int | Sequence[float]) -> tuple[float, ...]:
    if isinstance(times, int):
        if times < 2:
            raise InputError(f"the number of frames is {times}; give at least 2, A and B, or times of your own")
        return tuple(float(t) for t in np.linspace(0, 1, times))
    try:
        moments = tuple(float(t) for t in times)
    except (TypeError, ValueError):
        raise InputError(f"times are {times!r}; give a number of frames, or numbers from 0 (A) to 1 (B)") from None
    if not moments or not all(math.isfinite(t) and 0 <= t <= 1 for t in moments):
        raise InputError(f"times are {list(moments)}; give at least one, each from 0 (A) to 1 (B)")
    if list(moments) != sorted(moments):
        raise InputError(f"times are {list(moments)}; give them in order, from A to B")
    return moments


def _checked(size: tuple[int, int], least: int) -> tuple[int, int]:
    height, width = whole_sizes(size, 2, "the size")
    if min(height, width) < least:
        raise InputError(f"the size is {tuple(size)}; give a height and a width of at least {least} px")
    return height, width


def _shares(report: Report, *parts: tuple[bool, float]) -> list[Report]:
    """A report for each part of the work, of which some are done and all take so long beside each other."""
    lengths = [length if done else 0.0 for done, length in parts]
    ends = np.cumsum(lengths) / sum(lengths)
    return [_share(report, end - length / sum(lengths), end) for end, length in zip(ends, lengths, strict=True)]


def _share(report: Report, begin: float, end: float) -> Report:
    return lambda what, part: report(what, begin + (end - begin) * part)
