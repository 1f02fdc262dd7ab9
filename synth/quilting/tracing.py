"""Where in the exemplars themselves a quilt's pixels come from, through the turns and sizes of its variants."""

from collections.abc import Sequence

import numpy as np
from torch import Tensor

from synth.quilting.synthesis import Quilt, QuiltSettings, variants_of


def origins(result: Quilt, exemplars: Sequence[Tensor], settings: QuiltSettings) -> np.ndarray:
    """Where each pixel of an image quilted from exemplars (C, H, W) is from: exemplar, row, column; (3, H, W) int64.

    Of a variant that was turned or scaled it is the exemplar's pixel nearest to the one shown.
    """
    place = result.offset.numpy() + np.indices(result.patch.shape)
    found = np.empty((3, *result.patch.shape), np.int64)
    sources = result.source.numpy()
    for number, (home, variant, _) in enumerate(variants_of(exemplars, settings)):
        here, size = sources == number, np.array(exemplars[home].shape[-2:])[:, None]
        center = (np.array(variant.image.shape[-2:])[:, None] - 1) / 2
        there = np.rint(variant.matrix @ (place[:, here] - center) + (size - 1) / 2).astype(np.int64)
        found[0, here] = home
        found[1:, here] = there.clip(0, size - 1)
    return found


def turns(result: Quilt, exemplars: Sequence[Tensor], settings: QuiltSettings) -> np.ndarray | None:
    """What takes directions in the exemplars, x first, y down, to those of a quilted image's pixels: (2, 2, H, W).

    None where no variant that is mirrored or turned was asked for.
    """
    matrices = [_directions(variant.matrix) for _, variant, _ in variants_of(exemplars, settings)]
    if all((matrix == np.eye(2)).all() for matrix in matrices):
        return None
    return np.stack(matrices)[result.source.numpy()].transpose(2, 3, 0, 1)


def _directions(matrix: np.ndarray) -> np.ndarray:
    """What takes directions of an exemplar to those of a variant, x first, from the variant's matrix, row first."""
    back = np.linalg.inv(matrix)
    return (back / np.sqrt(abs(np.linalg.det(back))))[::-1, ::-1].round(12) + 0.0
