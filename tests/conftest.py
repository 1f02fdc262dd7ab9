"""What holds for all tests."""

import fcntl
import os
from collections.abc import Callable, Iterator
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


@pytest.fixture(scope="session", autouse=True)
def _compiled_by_one(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A function that several workers need at once one of them compiles: the others wait, and find it on the disk."""
    if WORKERS == 1:
        yield
        return
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher

    compiled, folder = Dispatcher.compile, tmp_path_factory.getbasetemp().parent

    def by_one(self: Any, signature: Any) -> Any:
        if self.stats.cache_path is None:
            return compiled(self, signature)
        name = f"{self.py_func.__module__}.{self.py_func.__qualname__}.lock"
        with global_compiler_lock, (folder / name).open("w") as lock:  # of threads, then of processes
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compiled(self, signature)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dispatcher, "compile", by_one)
        yield


@pytest.fixture(autouse=True)
def _threads_as_they_were() -> Iterator[None]:
    """What a test, or a command in it, sets the number of threads to, the next one does not see."""
    import faiss  # both after what they read
    import torch

    torch_had, faiss_had = torch.get_num_threads(), faiss.omp_get_max_threads()
    yield
    torch.set_num_threads(torch_had)
    faiss.omp_set_num_threads(faiss_had)


@pytest.fixture
def in_turn() -> None:
    """One thread, so that what threads would share is done in turn."""
    import torch

    torch.set_num_threads(1)


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
