"""Polynomials of the place on a picture, orthonormal over what is known of it: what uneven light is told by."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from kwatra.base import product

FULL, MOST = 4, 6
"""Degree of the polynomials by which light is taken out, where soft shadows are left with 2, and up to which tones are
compared."""

CALM = 1e-3
"""What light's mean square slope over the whole of a picture that is not known everywhere costs beside the mean square
by which it differs where it is known. Polynomials that go on into a hole as they like are wrong there by .38 of log v
where it is half a picture, .25 where it is .4 of it at a side; with this by .17 and .15, with a third or three times of
it by .17 and .17, or .19 and .15 (three textures under five lights). In holes that are surrounded it is .02 to .05."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Polynomials of the place up to degree MOST, orthonormal where they are `at` (k, n); `degrees` (k,) are theirs.

    mixing (k, k): what makes them of Legendre's.
    """

    at: Any
    degrees: Any
    mixing: Any

    @classmethod
    def over(cls, known: Any) -> "Basis":
        """Those over the known pixels of a picture (H, W)."""
        down, right = (_legendre(size) for size in known.shape)
        at = torch.from_numpy(np.stack([np.outer(down[d - k], right[k])[known] for d, k in _powers()]))
        overlap = product(at, at.T).numpy() / at.shape[1]
        mixing = np.linalg.inv(np.linalg.cholesky(overlap + 1e-9 * np.eye(len(at))))
        degrees = np.array([d for d, _ in _powers()])
        return cls(product(torch.from_numpy(mixing), at).numpy(), degrees, mixing)

    def on(self, light: Any) -> Any:
        """The light (n,) at the known pixels of coefficients (k,)."""
        return np.einsum("k,kn->n", light, self.at)

    def legendre(self, light: Any) -> Any:
        """Coefficients (k,) as those of Legendre's polynomials."""
        return np.einsum("k,kj->j", light, self.mixing)

    def calmed(self, light: Any) -> Any:
        """Coefficients (k,) of degrees up to FULL, of what differs little from that light but is level where it can be.

        It is the q with the least |q - light|^2 + CALM q'Gq, where G is of the mean products of slopes.
        """
        low = self.degrees <= FULL
        mixing = self.mixing[low][:, low]
        slopes = np.einsum("ij,jk,lk->il", mixing, _slopes()[low][:, low], mixing)
        calm = np.zeros_like(light)
        calm[low] = np.linalg.solve(np.eye(len(slopes)) + CALM * slopes, light[low])
        return calm

    @staticmethod
    def field(light: Any, shape: Sequence[int]) -> Any:
        """The sum (H, W) of Legendre's polynomials with these coefficients (k,)."""
        down, right = (_legendre(size) for size in shape)
        across = np.zeros((MOST + 1, shape[1]))
        for (d, k), much in zip(_powers(), light, strict=True):
            across[d - k] += much * right[k]
        return np.einsum("ky,kx->yx", down, across)


def _powers() -> list[tuple[int, int]]:
    """Of each polynomial of two places its degree, and how much of that is in the second; by degree."""
    return [(d, k) for d in range(MOST + 1) for k in range(d + 1)]


def _slopes() -> Any:
    """The mean products (k, k) of the slopes of Legendre's polynomials over the picture, per half a side."""
    n = np.arange(MOST + 1)
    least = np.minimum.outer(n, n)
    steep = np.where((n[:, None] + n) % 2 == 0, least * (least + 1) / 2, 0.0)
    flat = np.diag(1 / (2 * n + 1))
    down, right = np.array([(d - k, k) for d, k in _powers()]).T
    return (
        steep[np.ix_(down, down)] * flat[np.ix_(right, right)] + flat[np.ix_(down, down)] * steep[np.ix_(right, right)]
    )


def _legendre(size: int) -> Any:
    """Legendre's polynomials (MOST + 1, size) over a side of the picture."""
    return np.polynomial.legendre.legvander((np.arange(size) + 0.5) / size * 2 - 1, MOST).T
