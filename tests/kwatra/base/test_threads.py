import threading
import time

import pytest
import torch

from kwatra.base import by_one_thread, by_our_threads, even_ranges, shared, threads_shared


@pytest.fixture(params=[1, 2, 3])
def threads(request):
    torch.set_num_threads(request.param)
    return request.param


@pytest.mark.parametrize(("items", "parts"), [(10, 3), (9, 3), (2, 4), (0, 2), (5, 1)])
def test_even_ranges_go_on_where_the_one_before_ends_and_differ_by_one_at_most(items, parts):
    found = even_ranges(items, parts)
    assert [item for low, high in found for item in range(low, high)] == [*range(items)]
    lengths = [high - low for low, high in found]
    assert len(lengths) == parts
    assert max(lengths) - min(lengths) <= 1


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_each_item_is_called_once_and_results_keep_their_order(threads, count):
    called = []

    def square(n):
        called.append(n)
        time.sleep(0.001 * (count - n))  # later ones are done first
        return n * n

    assert shared(square, range(count)) == [n * n for n in range(count)]
    assert sorted(called) == list(range(count))


def test_calls_run_side_by_side_in_as_many_threads_as_torch_has(threads):
    together = threading.Barrier(threads)
    assert shared(lambda n: together.wait(timeout=20) >= 0, range(threads)) == [True] * threads


def test_calls_may_share_work_of_their_own(threads):
    found = shared(lambda n: sum(shared(lambda k: 10 * n + k, range(4))), range(5))
    assert found == [40 * n + 6 for n in range(5)]


def test_after_an_error_nobody_goes_on(threads):
    called = []

    def refuse(n):
        called.append(n)
        time.sleep(0.01)
        raise ValueError(f"item {n}")

    with pytest.raises(ValueError, match="item"):
        shared(refuse, range(50))
    assert len(called) <= threads


def test_long_calls_divide_threads_among_them_and_leave_their_number_as_it_was(threads):
    assert shared(lambda _: torch.get_num_threads(), [0]) == [threads]
    assert shared(lambda _: torch.get_num_threads(), range(2)) == [max(threads // 2, 1)] * 2
    assert shared(lambda n: n + 1, range(5)) == [1, 2, 3, 4, 5]
    assert shared(lambda _: torch.get_num_threads(), range(7), together=1) == [threads] * 7
    with pytest.raises(ValueError, match="no 1"):
        shared(refuse, range(3))
    assert torch.get_num_threads() == threads


def test_torch_uses_one_thread_for_a_while_and_as_many_as_before_even_after_an_error(threads):
    alone = by_one_thread()(torch.get_num_threads)
    assert alone() == 1
    with pytest.raises(ValueError, match="no 1"):
        by_one_thread()(refuse)(1)
    assert torch.get_num_threads() == threads


def test_torch_leaves_its_threads_to_what_is_shared_for_a_while(threads):
    with by_our_threads():
        assert (torch.get_num_threads(), threads_shared()) == (1, threads)
        assert (
            shared(lambda _: (torch.get_num_threads(), threads_shared()), range(2)) == [(1, max(threads // 2, 1))] * 2
        )
        together = threading.Barrier(threads)
        assert shared(lambda n: together.wait(timeout=20) >= 0, range(threads)) == [True] * threads
        with by_one_thread():
            assert (torch.get_num_threads(), threads_shared()) == (1, 1)
        with pytest.raises(ValueError, match="no 1"):
            shared(refuse, range(3))
        assert (torch.get_num_threads(), threads_shared()) == (1, threads)
    assert (torch.get_num_threads(), threads_shared()) == (threads, threads)
    assert shared(lambda _: threads_shared(), range(2)) == [max(threads // 2, 1)] * 2


@pytest.mark.parametrize("together", [2, 3])
def test_so_many_long_calls_are_under_way_at_a_time(together):
    torch.set_num_threads(2)
    meeting, under_way, most = threading.Barrier(together), [], []

    def call(number):
        under_way.append(number)
        meeting.wait(timeout=20)  # of fewer nobody would go on
        most.append(len(under_way))
        meeting.wait(timeout=20)
        under_way.remove(number)

    shared(call, range(2 * together), together)
    assert max(most) == together
    assert shared(lambda _: torch.get_num_threads(), range(4), together) == [1] * 4


def refuse(number):
    raise ValueError(f"no {number}" if number else "no 1")
