import numba
import numpy as np
import pytest
import torch
from numba.core import event

from kwatra.base.compiled import Compiled, compiling, jitted


def add(values, more, low, high):
    for i in range(low, high):
        values[i] += more[i]


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("count", [0, 7, 1000])
def test_every_item_is_worked_on_once_by_any_number_of_threads(threads, count):
    torch.set_num_threads(threads)
    values, more = torch.zeros(count), torch.arange(count, dtype=torch.float32)
    Compiled(add)(count, values, more)
    assert torch.equal(values, more)


def test_a_function_that_cannot_be_kept_is_compiled_all_the_same(monkeypatch):
    njit = numba.njit

    def nowhere(*arguments, cache=False, **options):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return njit(*arguments, **options)

    monkeypatch.setattr(numba, "njit", nowhere)
    assert jitted(lambda x: x + 1)(2) == 3


def half_of_the_first(values):
    return values[0] / 2


def test_what_two_processes_compile_at_once_for_different_types_is_told_apart(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    floats, integers = np.full(1, 3, np.float32), np.full(1, 3, np.int32)
    one, other, later = (jitted(half_of_the_first) for _ in range(3))
    file, written = one._cache._cache_file, []
    with monkeypatch.context() as slow:
        slow.setattr(file, "_save_data", lambda *what: written.append(what))
        one(floats)
    monkeypatch.setattr(other._cache._cache_file, "_load_index", dict)  # it looked before the first one wrote
    other(integers)
    file._save_data(*written[0])
    assert later(integers) == 1.5
    assert later.stats.cache_hits


def test_it_is_told_when_a_loop_is_compiled_and_not_when_one_is_found_on_the_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    told = []

    class Asking(event.Listener):
        def on_start(self, event):
            told.append(compiling())

        def on_end(self, event):
            pass

    one, other = jitted(half_of_the_first), jitted(half_of_the_first)
    with event.install_listener("numba:compile", Asking()):
        one(np.ones(1))
        assert told
        assert all(told)
        told.clear()
        other(np.ones(1))
    assert not told
    assert not compiling()
