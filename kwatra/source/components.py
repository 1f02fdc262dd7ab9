"""The leading principal components of many rows, the same bits for any number of threads."""

import torch
from torch import Tensor

from kwatra.base import product


def random_probe(shape: tuple[int, int], dims: int, generator: torch.Generator) -> Tensor:
    """What `randomized_basis` looks along in rows of a shape (N, D): random directions (D, <= dims + 8)."""
    return torch.randn(shape[1], min(min(dims, *shape) + 8, *shape), dtype=torch.float32, generator=generator)


def randomized_basis(rows: Tensor, dims: int, probe: Tensor) -> Tensor:
    """Leading right singular vectors (D, <= dims) of rows (N, D) by randomized subspace iteration (Halko 2011, 4.4).

    Orthonormal bases come from eigenvectors of small Gram matrices: unlike a QR of the tall matrix, these are the
    same bits for any number of threads.
    """
    dims, probe = min(dims, *rows.shape), probe.to(rows)
    for _ in range(2):
        probe = _orthonormal(product(rows.T, product(rows, probe)))
    reduced = product(rows, probe).double()
    _, vectors = torch.linalg.eigh(product(reduced.T, reduced))
    return probe @ vectors.flip(1)[:, :dims].to(rows)


def _orthonormal(columns: Tensor) -> Tensor:
    """An orthonormal basis of what the columns span; directions lost to rounding become zero."""
    columns = columns.double()
    columns = columns / columns.norm(dim=0).clamp(min=1e-30)
    values, vectors = torch.linalg.eigh(product(columns.T, columns))
    scale = torch.where(values > 1e-9 * values[-1], values.clamp(min=1e-30).rsqrt(), 0.0)
    return (columns @ (vectors * scale)).float()
