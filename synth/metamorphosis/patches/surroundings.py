"""What surrounds a texture, made: frames in which elements shrink see more of it than its exemplar shows."""

import torch
import torch.nn.functional as F
from torch import Tensor

from synth.texture.filling import fill


def surrounded(image: Tensor, features: Tensor, zoom: float, preset: str, seed: int) -> tuple[Tensor, Tensor]:
    """An image (C, H, W), 0 to 1, in the middle of one about `zoom` >= 1 times larger, and its features (H, W) there.

    What is around it is filled with its own texture (see `synth.fill`), and has the features of where that comes from.
    """
    down, right = (round((zoom - 1) * side / 2) for side in image.shape[1:])
    if down == right == 0:
        return image, features
    around = (right, right, down, down)
    hole = F.pad(torch.zeros(image.shape[1:], dtype=torch.bool), around, value=True)
    made = fill(F.pad(image, around), hole, preset=preset, seed=seed)
    rows, columns = torch.as_tensor(made.source)[1:].long() - torch.tensor([down, right]).view(2, 1, 1)
    return made.image, features[rows, columns]
