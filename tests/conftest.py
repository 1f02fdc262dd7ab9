"""What holds for all tests."""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import synth  # noqa: F401  # before torch: waiting threads sleep, which a busy machine thanks with twice the speed

# workers beside each other (pytest-xdist) share the cores, and so do the processes that tests start
WORKERS = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
if WORKERS > 1:  # read by torch and faiss when they are loaded, which is later
    os.environ.setdefault("OMP_NUM_THREADS", str(max(1, (os.cpu_count() or 1) // WORKERS)))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first: a worker that comes to one of them last keeps all others waiting."""
    items.sort(key=lambda item: not item.path.name.startswith(("test_gallery", "test_bench", "test_readme")))


@pytest.fixture
def recomputed_seams() -> Callable[[Any], np.ndarray]:
    """The seam costs of a sheet computed anew from its places alone: what it remembers, at every moment."""

    def recomputed(sheet: Any) -> np.ndarray:
        seams = np.zeros_like(sheet.seams)
        for axis in range(len(sheet.shape)):
            label = np.roll(sheet.label, -1, axis)
            seam = (sheet.label != label) & sheet.filled & (label >= 0)
            if not sheet.periodic[axis]:
                seam[tuple(-1 if d == axis else slice(None) for d in range(seam.ndim))] = False
            after = np.roll(sheet.places, -1, axis - len(sheet.shape))
            seams[axis][seam] = sheet.cost.seam(sheet.places[..., seam], after[..., seam], axis, len(sheet.shape))
        return seams

    return recomputed
