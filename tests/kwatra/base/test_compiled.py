import numba
import pytest
import torch

from kwatra.base.compiled import Compiled, jitted


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
