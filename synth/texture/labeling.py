"""Labels: guides that name textures, each of which fills rectangles of the exemplars, as pictures put side by side do.

What such a guide asks for is not texture that changes from place to place but several textures, so each is made by
itself (`synth.texture.patchwork`), as good as alone. Labels of other forms, drawn into one picture, also tell what is
seen where one texture turns into another: those guide what is laid (`synth.texture.guidance`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from kwatra import InputError
from kwatra.base import over_channels
from synth.texture.form import Form, Image, map_like, size_of
from synth.texture.guidance import Guide
from synth.words import counted

MOST, LEAST = 64, 8
"""A guide of more values is a map of what varies; and so is one of narrower rectangles, in px: of a smooth map, columns
of one value are. Guards, not tuned."""

SURE = 0.95
"""So much of an output's map has to show labels exactly; what lies between two, as along borders that were drawn
smoothly, counts as the label it is most like."""

Rectangle = tuple[slice, slice]


@dataclass(frozen=True)
class Labels:
    """Textures, each as the exemplars' rectangles that show it, and which of them is `wanted` where, (H, W).

    Every one is wanted somewhere.
    """

    textures: list[list[tuple[int, Rectangle]]]
    wanted: np.ndarray

    @classmethod
    def of(cls, guide: Guide) -> "Labels | None":
        """The labels that a guide of stills is of; None if it is none of labels."""
        maps = [each.numpy() for each in guide.exemplars]
        if maps[0].ndim != 3:
            return None
        values = _values([each.reshape(len(each), -1) for each in maps])
        if values is None:
            return None
        found = [_rectangles(maps, value) for value in values.T]
        nearest, exact = _nearest(guide.output.numpy(), values)
        textures = [shown for shown in found if shown is not None]
        if len(textures) < len(found) or exact < SURE:
            return None
        used, wanted = np.unique(nearest, return_inverse=True)
        return cls([textures[number] for number in used.tolist()], wanted.reshape(nearest.shape))


def labels(exemplars: Sequence[Image], wanted: Image) -> tuple[list[Image], Image]:
    """The guide that puts each of several exemplars where an image has its shade, the first where it is darkest.

    All (H, W) or (H, W, C), or tensors (C, H, W); `wanted` shows as many shades as there are exemplars, channels
    counting alike, but for a few pixels between two shades. Returns a map of one channel for each exemplar, and the
    output's, see `synthesize`. InputError for another number of shades.
    """
    form: Form[Any] = Form.of([wanted], "the map of labels")
    shades = over_channels(form.normalized(wanted).double()).numpy()
    values, counts = np.unique(shades, return_counts=True)
    count = len(exemplars)
    chosen = np.sort(values[np.argsort(-counts, kind="stable")[:count]])
    if len(chosen) < count or counts[np.isin(values, chosen)].sum() < SURE * shades.size:
        there = counted(len(values), "shade") if len(values) <= MOST else f"more than {MOST} shades"
        raise InputError(f"the map of labels has {there} for {counted(count, 'exemplar')}; draw a shade for each")
    nearest, _ = _nearest(shades[None], chosen[None])
    shown: list[np.ndarray] = [np.full(size_of(exemplar), number) for number, exemplar in enumerate(exemplars)]
    made: list[Image] = [map_like(wanted, each.astype(np.uint8)) for each in (*shown, nearest)]
    return made[:-1], made[-1]


def _values(maps: Sequence[np.ndarray]) -> np.ndarray | None:
    """The values (G, n) that maps (G, pixels) show; None if there are more than MOST."""
    flat = np.concatenate(maps, 1)
    numbers = np.zeros(flat.shape[1], np.int64)
    for channel in flat:
        own, there = np.unique(channel, return_inverse=True)
        if len(own) > MOST:
            return None
        _, first, numbers = np.unique(numbers * len(own) + there, return_index=True, return_inverse=True)
        if len(first) > MOST:
            return None
    return flat[:, first]


def _rectangles(maps: Sequence[np.ndarray], value: np.ndarray) -> list[tuple[int, Rectangle]] | None:
    """Where in maps (G, H, W) a value (G,) is shown; None if not in rectangles that are large enough."""
    shown = list[tuple[int, Rectangle]]()
    for number, each in enumerate(maps):
        there = (each == value[:, None, None]).all(0)
        parts, _ = ndimage.label(there)
        for box in ndimage.find_objects(parts):
            if not there[box].all() or min(there[box].shape) < LEAST:
                return None
            shown.append((number, box))
    return shown


def _nearest(output: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float]:
    """Which of values (G, n) each pixel of a map (G, H, W) is most like, (H, W), and the share that is just that."""
    nearest = np.zeros(output.shape[1:], np.int64)
    least = np.full(output.shape[1:], np.inf)
    for number, value in enumerate(values.T):
        away = ((output - value[:, None, None]) ** 2).sum(0)
        nearer = away < least
        nearest[nearer], least[nearer] = number, away[nearer]
    return nearest, float((least == 0).mean())
