"""Normal maps whose pixels were mirrored or turned: their directions turn with them.

A normal's x points right and its y up, or down in maps made for DirectX; both lie in the first two channels, about the
middle of their range (about 0 where floating-point values are below it). Its z, and any other channel, stays.
"""

import re

import numpy as np

from synth.io.kinds import Array

MIRRORED = 1_000_000
"""What is added to the number that says how a piece was turned, where it was mirrored, too."""


def is_normal(name: str) -> bool:
    """Whether a map of this name holds normals: normal, normals, normal_gl, NormalDX, brick_normal and the like."""
    return re.search(r"(^|[\W_])normal", name.lower()) is not None


def points_down(name: str) -> bool:
    """Whether y points down in a map of this name: where it ends in dx, as DirectX has it."""
    return name.lower().endswith("dx")


def coded(turns: Array) -> Array:
    """Matrices (2, 2, H, W) as whole numbers (H, W): thousandths of a degree, counterclockwise; MIRRORED more where
    the piece was mirrored from left to right before it was turned.
    """
    mirrored = np.linalg.det(turns.transpose(2, 3, 0, 1)) < 0
    first = np.where(mirrored, -turns[:, 0], turns[:, 0])  # where what points right points to
    angle = np.rint(np.degrees(np.arctan2(-first[1], first[0])) * 1000).astype(np.int64) % 360_000
    return angle + MIRRORED * mirrored


def decoded(codes: Array) -> Array:
    """The matrices (2, 2, H, W) that `coded` made whole numbers (H, W) of."""
    angle = np.radians((codes % MIRRORED) / 1000)
    cos, sin, hand = np.cos(angle).round(9), np.sin(angle).round(9), np.where(codes >= MIRRORED, -1.0, 1.0)
    return np.stack([np.stack([cos * hand, sin]), np.stack([-sin * hand, cos])]) + 0.0


def turned_normals(values: Array, turns: Array | None, down: bool = False, middle: float | None = None) -> Array:
    """Normals (*S, C) of any dtype, C >= 2, turned by matrices (2, 2, *S), x first, y down; None turns nothing.

    down: whether y points down in the map, too. middle: of their range; None where the values tell. Where a matrix is
    the identity values stay bit for bit; quarter turns and mirroring are exact.
    """
    if turns is None or values.shape[-1] < 2:
        return values
    whole = values.dtype.kind in "ui"
    if middle is None:
        middle = np.iinfo(values.dtype).max / 2 if whole else 0.0 if values.min() < 0 else 0.5
    hand = np.array([[1.0, 1.0], [1.0, 1.0]] if down else [[1.0, -1.0], [-1.0, 1.0]])
    matrix = turns.astype(np.float64) * hand.reshape(2, 2, *[1] * (turns.ndim - 2))
    moved = np.einsum("ij...,...j->...i", matrix, values[..., :2].astype(np.float64) - middle) + middle
    moved = np.rint(moved).clip(0, 2 * middle) if whole else moved
    identity = (turns == np.eye(2).reshape(2, 2, *[1] * (turns.ndim - 2))).all((0, 1))
    made = values.copy()
    made[..., :2] = np.where(identity[..., None], values[..., :2], moved.astype(values.dtype))
    return made
