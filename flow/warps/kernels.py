"""The interpolations' kernels: the weights of the pixels around a place along an axis, by how far it lies past one.

Each is plain arithmetic on f, in [0, 1), so that it serves tensors and, compiled, numbers. The place lies f past the
middle one of the pixels, or the left one of the two in the middle. Weights sum to 1; at a pixel that alone is read.
"""

from collections.abc import Callable
from typing import Any


def nearest(f: Any) -> tuple[Any, ...]:
    """The nearest pixel alone."""
    return (0 * f + 1,)


def linear(f: Any) -> tuple[Any, ...]:
    """The two pixels on either side."""
    return 1 - f, f


def catmull_rom(f: Any) -> tuple[Any, ...]:
    """The cubic through four pixels that has their slopes (Catmull and Rom 1974)."""
    square = f * f
    return (
        ((1 - 0.5 * f) * f - 0.5) * f,
        (1.5 * f - 2.5) * square + 1,
        ((2 - 1.5 * f) * f + 0.5) * f,
        (0.5 * f - 0.5) * square,
    )


def lanczos(f: Any) -> tuple[Any, ...]:
    """sinc(d) sinc(d / 3) at d = f - k of k = -2 to 3, but for a factor that their sum takes out.

    At all six d the sine of pi d / 3 is, but for its sign, p, q or p + q, those of pi f / 3 and pi (1 - f) / 3.
    """

    def sinc(d: Any) -> Any:  # of d / 3, by its series, to 1e-9
        x = d * d * 1.0966227112321508
        return 1 + x * (-1 / 6 + x * (1 / 120 + x * (-1 / 5040 + x * (1 / 362880 - x / 39916800))))

    rest = 1 - f
    one, other = sinc(f), sinc(rest)
    p, q, both = f * one, rest * other, f * rest
    far, near = (2 + both) * (2 + both), (6 + both) * (6 + both)  # one divides by the other's part: so none has to
    middle, near, far = far * near, -(p + q) * both * near, both * far
    weights = (
        far * q * (3 - f) * (3 - f),
        near * (2 - f) * (2 - f),
        middle * one * rest,
        middle * other * f,
        near * (1 + f) * (1 + f),
        far * p * (2 + f) * (2 + f),
    )
    share = 1 / (weights[0] + weights[1] + weights[2] + weights[3] + weights[4] + weights[5])
    return (
        share * weights[0],
        share * weights[1],
        share * weights[2],
        share * weights[3],
        share * weights[4],
        share * weights[5],
    )


KERNELS: dict[str, tuple[int, Callable[[Any], tuple[Any, ...]]]] = {
    "nearest": (1, nearest),
    "bilinear": (2, linear),
    "bicubic": (4, catmull_rom),
    "lanczos": (6, lanczos),
}
"""For each mode how many pixels it reads along an axis, and their weights."""
