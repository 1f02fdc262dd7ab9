"""What comes of a synthesis: the picture or video, and where its pixels come from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

from kwatra import InputError, Result
from synth.texture.form import Form, Image
from synth.texture.normals import turned_normals

Map = TypeVar("Map", Tensor, np.ndarray)


@dataclass(frozen=True)
class Synthesis(Generic[Image]):
    """A synthesized picture or video.

    image: of the same kind as the exemplar. source (3, H, W) int64: for each pixel the number of the image it comes
    from, -1 for pixels that were given, and its row and column there; of a video (4, T, H, W), with the frame before
    the row. result: what the engine returned (its image normalized, channels first); of several textures
    (`synth.texture.patchwork`) its `where` is empty, as they have no canvas together, and it has no stages. turns
    (2, 2, H, W), or (2, 2, T, H, W): what takes directions in the exemplar, x first, y down, to those of the pixels;
    None where no mirrored or turned variant was used. even: the exemplars without the light that falls on them
    unevenly, which it is of then; empty where they are as they were given.
    """

    image: Image
    source: np.ndarray
    result: Result
    form: Form[Image]
    turns: np.ndarray | None = None
    even: Sequence[Image] = ()

    @property
    def stages(self) -> list[Image]:
        """The picture after each level, at that level's resolution, in the exemplar's kind and range."""
        return [self.form.restored(stage.image.cpu()) for stage in self.result.stages]

    def take(self, maps: Map | Sequence[Map]) -> Map:
        """Rearrange a map that belongs to the exemplar (one per image) just as the exemplar's pixels were.

        Arrays are (H, W) or (H, W, C), tensors (C, H, W); of videos (T, H, W) or (T, H, W, C), and (C, T, H, W). Values
        and dtype stay exactly as they are. Pixels that come from no exemplar, because they were given, are 0. Raises
        InputError for maps of another size than the exemplar's.
        """
        several: list[Map] = [maps] if isinstance(maps, (Tensor, np.ndarray)) else list(maps)
        if len(several) <= self.source[0].max():
            raise InputError(f"{len(several)} maps were given, but the exemplar has more images; give one for each")
        axes = len(self.source) - 1
        for given, size in zip(several, self.form.sizes, strict=False):
            own = tuple(given.shape[-axes:] if isinstance(given, Tensor) else given.shape[:axes])
            if own != size:
                raise InputError(f"a map has size {own} but its image {size}; give maps of the exemplar's size")
        arrays: list[np.ndarray] = [
            m.detach().cpu().movedim(0, -1).numpy() if isinstance(m, Tensor) else m for m in several
        ]
        made = taken(arrays, self.source)
        rearranged: Any = torch.from_numpy(made).movedim(-1, 0) if isinstance(several[0], Tensor) else made
        return rearranged  # the kind of maps that were given

    def take_normals(self, maps: np.ndarray | Sequence[np.ndarray], down: bool = False) -> np.ndarray:
        """As `take` of normal maps (H, W, C), one per image, turned with the pieces that were mirrored or turned.

        x and y lie in the first two channels, about the middle of their range; down: y points down (DirectX).
        """
        return turned_normals(self.take(maps), self.turns, down)


def taken(maps: Sequence[np.ndarray], source: np.ndarray) -> np.ndarray:
    """Maps (*T, C) or (*T), one per image, rearranged as `source` (1 + n, *S) says: image, place; -1 leaves 0."""
    made = np.zeros((*source.shape[1:], *maps[0].shape[len(source) - 1 :]), maps[0].dtype)
    for number, array in enumerate(maps):
        here = source[0] == number
        made[here] = array[tuple(axis[here] for axis in source[1:])]
    return made


def joined(parts: Sequence[Synthesis[Image]]) -> Synthesis[Image]:
    """The stretches of a video as one; its `stages` are none."""
    results, form = [part.result for part in parts], parts[0].form
    image, source, where = (torch.cat([getattr(r, name) for r in results], 1) for name in ("image", "source", "where"))
    rows = [{"stretch": number, **row} for number, result in enumerate(results) for row in result.energies]
    result = Result(image, source, where, rows, [], results[-1].stopped)
    turns = [part.turns for part in parts if part.turns is not None]
    return Synthesis(
        form.restored(image.cpu()), source.cpu().numpy(), result, form, np.concatenate(turns, 2) if turns else None
    )
