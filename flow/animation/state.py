"""What an animation goes on from."""

from dataclasses import dataclass

from torch import Tensor


@dataclass(frozen=True)
class State:
    """All that the next frame follows from, on the CPU.

    number: of the frame, from 0. source (2, H, W) float32: where on the exemplar's canvas each pixel is read, x first,
    but for mortar that is shown along tears (`showing.mortar`); of a video on its frames, one under the other (`film`),
    of a picture whose elements turn on the still that it was grown to (`film.growing`). inside (H, W): where there is
    texture.
    image (C, H, W): what is shown, and of maps that go along (C + M, H, W). fading (2 + 1 + C + M, H, W): of a video
    what fades below that (`showing.fading`); None where nothing does. left (H, W): of a picture how worn blocks
    were left that were tried (`renewing.renewal`); None where none was. place (2, H, W): of a scene where
    each pixel belongs (`renewing.scenes`); None where it is its texture's own place. torn (H, W): of a wall how far in
    px pixels are from what tears it, on average over frames (`showing.mortar`); None of what is no wall.
    """

    number: int
    source: Tensor
    inside: Tensor
    image: Tensor
    fading: Tensor | None = None
    left: Tensor | None = None
    place: Tensor | None = None
    torn: Tensor | None = None
