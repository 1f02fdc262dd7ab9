"""Sizes of outputs that tile: a texture that repeats does so only in whole periods."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from synth import texture
from synth.saying import note

if TYPE_CHECKING:
    from torch import Tensor


def tile_size(tile: str | None, size: tuple[int, int], pictures: "Sequence[Tensor]") -> tuple[int, int]:
    """The size (height, width) for what `--tile` asks: "nearest" whole periods; "exact" is told where it holds none."""
    if tile is None:
        return size
    good = texture.whole_size(pictures, size, quickly=tile != "nearest")
    if good is None or good == size:
        return size
    if tile == "nearest":
        return good
    note(
        f"{size[1]}x{size[0]} holds no whole periods of this texture, which will show; {good[1]}x{good[0]} does: ask "
        "for that, or for --tile nearest"
    )
    return size
