import threading

import pytest
import torch

from kwatra.base import in_threads


@pytest.fixture(params=[1, 2, 3])
def threads(request):
    before = torch.get_num_threads()
    torch.set_num_threads(request.param)
    yield request.param
    torch.set_num_threads(before)


def test_results_stand_in_the_order_of_their_items(threads):
    assert in_threads(lambda n: n * n, iter(range(20))) == [n * n for n in range(20)]
    assert in_threads(lambda n: n, []) == []


def test_as_many_work_at_a_time_as_torch_has_threads(threads):
    together = threading.Barrier(threads, timeout=20)  # broken by an error, should too few come
    in_threads(lambda _: together.wait(), range(threads))


def test_an_error_of_one_item_is_raised(threads):
    with pytest.raises(ZeroDivisionError):
        in_threads(lambda n: 1 / n, [1, 0, 2])
