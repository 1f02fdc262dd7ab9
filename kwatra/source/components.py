"""The leading principal components of many rows, the same bits for any number of threads."""

import torch
from torch import Tensor


def randomized_basis(rows: Tensor, dims: int, generator: torch.Generator) -> Tensor:
    """Leading right singular vectors (D, <= dims) of rows (N, D) by randomized subspace iteration (Halko 2011, 4.4).

    Orthonormal bases come from eigenvectors of small Gram matrices: unlike a QR of the tall matrix, these are the
    same bits for any number of threads.
    """
    dims = min(dims, *rows.shape)
    probe = torch.randn(rows.shape[1], min(dims + 8, *rows.shape), generator=generator).to(rows)
    for _ in range(2):
        probe = _orthonormal(rows.T @ (rows @ probe))
    reduced = (rows @ probe).double()
    _, vectors = torch.linalg.eigh(reduced.T @ reduced)
    return probe @ vectors.flip(1)[:, :dims].to(rows)


def _orthonormal(columns: Tensor) -> Tensor:
    """An orthonormal basis of what the columns span; directions lost to rounding become zero."""
    columns = columns.double()
    columns = columns / columns.norm(dim=0).clamp(min=1e-30)
    values, vectors = torch.linalg.eigh(columns.T @ columns)
    scale = torch.where(values > 1e-9 * values[-1], values.clamp(min=1e-30).rsqrt(), 0.0)
    return (columns @ (vectors * scale)).float()
