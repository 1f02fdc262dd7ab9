"""Flow around obstacles: a field is bent so that nothing flows into them.

From a field v the gradient of a potential phi is taken away, the least change that leaves no flow through an
obstacle's edge: laplace phi = 0 where there is texture, dphi/dn = v.n on the edge, phi = 0 around the frame. Sources
and sinks of v stay as they are. Around a disc in a uniform flow this is potential flow, for which `flow.disc` has the
formula.
"""

from functools import lru_cache

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg
from torch import Tensor

from flow.fields.edge import Edge
from flow.fields.field import Field, Shape
from kwatra.base import check_mask

Array = NDArray[np.float64]

_MOST = 0.98
"""Speeds before and after are those of this quantile: beside a corner a few pixels may be much faster."""

_TINY = 1e-30
"""What divides instead of 0."""

_LITTLE = 1e-7
"""What an obstacle encloses has its phi but for a constant, which this chooses."""


def around(field: Field, mask: Tensor) -> Field:
    """A field that flows around what the mask (H, W) leaves out (False = obstacle), for frames of the mask's size.

    No pixel's center is carried into an obstacle, and inside it all is at rest. Where the way is narrow the flow would
    be faster than the field given; it is slowed until 98% of the pixels are as fast as theirs were, and the rest, at
    sharp corners, no faster than the fastest. To make it faster, scale the field given, not the result.

    Setting it up factorizes a sparse matrix with a row per pixel (256x256: about a second); a steady field is solved
    for once, another at each time. Raises InputError if the mask is not boolean (H, W) or covers everything.
    """
    check_mask(mask, mask.shape)
    obstacle = _Obstacle(mask.cpu())

    @lru_cache(1)
    def at(t: float, shape: Shape) -> Tensor:
        check_mask(mask, shape)
        return obstacle.bent(field(t, shape))

    return Field((lambda t, shape: at(0.0, shape)) if field.steady else at, field.steady)


class _Obstacle:
    """What a mask (H, W) leaves out, with the factorized Laplacian of the rest."""

    def __init__(self, mask: Tensor) -> None:
        self.edge = Edge(mask)
        self.solid = np.pad(~mask.numpy(), 1)
        laplacian = _laplacian(self.solid)
        self.solve = linalg.splu(laplacian, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve

    def bent(self, flow: Tensor) -> Tensor:
        """The flow (2, H, W) led around the obstacle, on the whole as fast as before and nowhere faster."""
        correction = torch.from_numpy(self._correction(flow.double().numpy())).float()
        bent = (flow + correction) * self.edge.mask
        here, before = (float(np.quantile(f.norm(dim=0)[self.edge.mask], _MOST)) for f in (bent, flow))
        slowed = bent * min(1.0, before / max(here, _TINY))
        limit = flow.norm(dim=0).max() / slowed.norm(dim=0).clamp(min=_TINY)
        return self.edge.keep_out(slowed * limit.clamp(max=1))

    def _correction(self, flow: Array) -> Array:
        """What bends the flow: at the edge -v.n, elsewhere -grad phi, first on pixels' sides, then averaged."""
        padded = np.pad(flow, ((0, 0), (1, 1), (1, 1)), mode="edge")
        across = [np.mean(_neighbors(padded[k], 1 - k), axis=0) for k in range(2)]
        closed = [np.logical_or(*_neighbors(self.solid, 1 - k)) for k in range(2)]
        inflow = sum(np.diff(across[k] * closed[k], axis=1 - k) for k in range(2))
        phi = np.zeros(self.solid.shape)
        free = ~self.solid[1:-1, 1:-1]
        phi[1:-1, 1:-1][free] = self.solve(inflow[free])
        sides = [np.where(closed[k], -across[k], -np.diff(_neighbors(phi, 1 - k), axis=0)[0]) for k in range(2)]
        return np.stack([(sides[0][:, 1:] + sides[0][:, :-1]) / 2, (sides[1][1:] + sides[1][:-1]) / 2])


def _laplacian(solid: NDArray[np.bool_]) -> sparse.csc_matrix:
    """For each free pixel the sum over its open sides of phi - phi(neighbor); phi is 0 on the ring around the frame.

    solid: (H + 2, W + 2), with that ring, where it is False.
    """
    free = ~solid[1:-1, 1:-1]
    number = np.full(solid.shape, -1)
    number[1:-1, 1:-1][free] = np.arange(free.sum())
    closed = [solid[1:-1, :-2], solid[1:-1, 2:], solid[:-2, 1:-1], solid[2:, 1:-1]]
    diagonal = 4 - np.sum(closed, axis=0)[free] + _LITTLE
    pairs = [np.stack(_neighbors(number, axis)).reshape(2, -1) for axis in range(2)]
    here, there = np.concatenate([pair[:, (pair >= 0).all(0)] for pair in pairs], axis=1)
    off = sparse.coo_matrix((np.full(len(here), -1.0), (here, there)), shape=(len(diagonal), len(diagonal)))
    return (sparse.diags(diagonal) + off + off.T).tocsc()


def _neighbors(padded: Array, axis: int) -> tuple[Array, Array]:
    """All pairs of neighbors along an axis of an array (H + 2, W + 2) with a ring, but for pairs of the ring."""
    inner = padded[1:-1] if axis == 1 else padded[:, 1:-1]
    return (inner[:, :-1], inner[:, 1:]) if axis == 1 else (inner[:-1], inner[1:])
