"""A flow moves a scene with all that it shows: each pixel keeps the place in the frame that it belongs to.

Texture that lives on drifts as it does in the exemplar. Where that drift is undone, as of falling water, what a pixel
shows comes from ever lower in the scene; did what replaces it come from there, too, that would fall on from there,
until the scene's lower end lay everywhere. So places are carried by the flow alone: what replaces texture comes from
around the place where that began, and only where there is none yet does a block bring its own.
"""

import torch
from torch import Tensor

from flow.animation.carrying import carried
from flow.animation.film import Film
from flow.animation.renewing.placing import Spot
from flow.warps import Lookup


def places(film: Film, source: Tensor) -> Tensor:
    """The places (2, *S), x first, in whatever frame, of source coordinates (2, *S)."""
    return torch.stack([source[0], source[1].remainder(film.pitch)])


def places_onward(film: Film, before: Tensor | None, source: Tensor, look: Lookup, inside: Tensor) -> Tensor | None:
    """The places (2, H, W) of a scene carried to the next frame as `look` says; None where places tell nothing.

    before (2, H, W): those of a frame that shows source coordinates (2, H, W) inside (H, W); None: its texture's own.
    """
    if not film.scene:
        return None
    return carried(places(film, source) if before is None else before, look, inside)


def home_of(place: Tensor, spot: Spot) -> Tensor:
    """The corner (2,), x first, of the block that is most of what belongs to a spot of a frame's places (2, H, W)."""
    here = place[(slice(None), *spot)]
    down, right = (torch.arange(side) for side in here.shape[1:])
    return torch.stack([(here[0] - right).median(), (here[1] - down[:, None]).median()])
