"""A picture's texture grown beyond the frame: what flows in goes on as what it belongs to.

An exemplar ends somewhere, mostly within elements. A copy that the flow has carried so far is replaced there, and what
it showed of an element is cut off. So where copies may turn the exemplar's place is taken by a still made of it, larger
than the frame: the first frame is its middle, and what a turning frame covers is all there.
"""

import math
from dataclasses import replace

import torch

from flow.animation.film.film import Film
from kwatra import Settings, begin, improve
from kwatra.source import look_up

_EVEN = 0.0
"""How much it counts that the larger still shows all of the exemplar: whole elements count more. Of made stones and
coins of 12 to 32 px that rotate .089 are cut after 60 frames of 2 px, .148 with 1."""


def grown(film: Film, shape: tuple[int, int], synthesis: Settings, seed: int) -> Film:
    """The film of a still that is synthesized from a picture's, and that a frame (H, W) does not leave while it turns.

    It is at most twice as long as the frame along an axis. Every pixel is one of the exemplar's (`Film.placed`), or
    between some, of elements that were made whole. A film whose copies keep their directions is returned as it is.
    """
    if not film.turning:
        return film
    across = math.hypot(*shape)
    margins = [min(math.ceil((across - side) / 2), side // 2) for side in shape]
    larger = [side + 2 * margin for side, margin in zip(shape, margins, strict=True)]
    beginning = begin(film.strip, larger, replace(synthesis, even=_EVEN), seed=seed).without_blocks()
    still = improve(beginning)
    owner, origin = torch.zeros_like(still.image[0]), look_up(film.strip.origin, still.where)
    strip = replace(film.strip, canvas=beginning.shown(film.strip.canvas, still.where), owner=owner, origin=origin)
    also = film.also
    maps = also and replace(strip, canvas=beginning.shown(also.canvas, still.where), weights=also.weights)
    return replace(film, strip=strip, pitch=larger[0], also=maps, placed=still.where)
