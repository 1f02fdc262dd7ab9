"""The cut against brute force: no labeling of a small grid may be cheaper than the one it finds."""

import itertools

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import csgraph

from kwatra.cut import FREE, KEEP, TAKE, VOID, best_cut, seams_after
from kwatra.cut.flow import sink_side
from kwatra.cut.network import cut_at_once, sides


def random_problem(rng, shape, metric=True):
    """States and pair costs as a canvas would make them: three or more 'patches' as random colours per pixel."""
    dims = len(shape)
    choice = rng.choice([KEEP, TAKE, FREE, FREE, FREE, VOID], size=shape)
    pairs = []
    for axis in range(dims):
        less = tuple(n - (d == axis) for d, n in enumerate(shape))
        at, bt, old = rng.integers(0, 50, (3, 2, *less))
        b, c = np.abs(at - bt)
        a = np.abs(at[0] - old[0]) if not metric else np.minimum(np.abs(old[0] - old[1]), b + c)
        pairs.append((a * rng.integers(0, 2, less), b, c))
    return choice, pairs


def brute_force(choice, pairs):
    free = np.argwhere(choice == FREE)
    best = None
    for taken in itertools.product([False, True], repeat=len(free)):
        take = choice == TAKE
        take[tuple(free.T)] = taken
        cost = sum(int(s.sum()) for s in seams_after(choice, take, pairs))
        best = cost if best is None else min(best, cost)
    return best


@pytest.mark.parametrize("shape", [(3, 4), (1, 9), (2, 2, 3), (3, 2, 2)])
@pytest.mark.parametrize("seed", range(12))
def test_cut_equals_the_best_of_all_labelings(shape, seed):
    rng = np.random.default_rng(seed)
    choice, pairs = random_problem(rng, shape)
    take = best_cut(choice, pairs)
    assert sum(int(s.sum()) for s in seams_after(choice, take, pairs)) == brute_force(choice, pairs)
    assert take[choice == TAKE].all()
    assert not take[(choice == KEEP) | (choice == VOID)].any()


@pytest.mark.parametrize("seed", range(12))
def test_without_the_triangle_inequality_the_cut_still_never_costs_more_than_keeping_all(seed):
    rng = np.random.default_rng(seed)
    choice, pairs = random_problem(rng, (3, 4), metric=False)
    choice[(choice == TAKE) | (choice == VOID)] = FREE
    take = best_cut(choice, pairs)
    after = sum(int(s.sum()) for s in seams_after(choice, take, pairs))
    assert after <= sum(int(a.sum()) for a, _, _ in pairs)
    # what is minimized takes an old seam between free pixels for no more than replacing it on both sides
    bounded, free = [], choice == FREE
    for axis, (a, b, c) in enumerate(pairs):
        both = np.take(free, range(free.shape[axis] - 1), axis) & np.take(free, range(1, free.shape[axis]), axis)
        bounded.append((np.where(both, np.minimum(a, b + c), a), b, c))
    assert sum(int(s.sum()) for s in seams_after(choice, take, bounded)) == brute_force(choice, bounded)


@pytest.mark.parametrize("shape", [(6, 7), (3, 4, 5)])
@pytest.mark.parametrize("seed", range(6))
def test_a_cut_is_given_up_where_it_changes_seams_by_more_than_is_asked(shape, seed):
    rng = np.random.default_rng(seed)
    choice, pairs = random_problem(rng, shape)
    taking = rng.integers(-20, 20, shape)
    take = best_cut(choice, pairs, taking)
    after = sum(int(seam.sum()) for seam in seams_after(choice, take, pairs))
    change = after - sum(int(a.sum()) for a, _, _ in pairs) + int(taking[take & (choice == FREE)].sum())

    def solved(most: int) -> bool:
        costs = [sides([np.asarray(pair[n], np.int32) for pair in pairs], choice.size) for n in range(3)]
        found = np.empty(choice.size, bool)
        done = cut_at_once(choice.astype(np.int8).ravel(), *costs, taking.astype(np.int64).ravel(), most, found)
        assert not done or (found == take.ravel()).all()
        return bool(done)

    assert solved(change)
    assert not solved(change - 1)


@pytest.mark.parametrize("shape", [(40,), (30, 34), (9, 11, 10)])
@pytest.mark.parametrize("seed", range(4))
def test_the_flow_cuts_as_an_independent_solver_does(shape, seed):
    rng = np.random.default_rng(seed)
    count, dims = int(np.prod(shape)), len(shape)
    node = np.arange(count).reshape(shape)
    weight = rng.integers(-200, 200, count) * (rng.random(count) < (0.1 if seed % 2 else 0.9))
    capacity, neighbor = np.zeros((count, 2 * dims), np.int64), np.full((count, 2 * dims), -1)
    for axis in range(dims):
        low, high = node.take(range(shape[axis] - 1), axis).ravel(), node.take(range(1, shape[axis]), axis).ravel()
        capacity[high, axis], neighbor[high, axis] = rng.integers(0, 100, len(high)), low
        capacity[low, 2 * dims - 1 - axis], neighbor[low, 2 * dims - 1 - axis] = rng.integers(0, 100, len(low)), high
    found = sink_side(weight, capacity, neighbor)
    full = np.zeros((count + 2, count + 2), np.int32)
    for d in range(2 * dims):
        there = neighbor[:, d] >= 0
        full[np.flatnonzero(there), neighbor[there, d]] = capacity[there, d]
    full[count, :count], full[:count, count + 1] = np.maximum(weight, 0), np.maximum(-weight, 0)
    network = sparse.csr_matrix(full)
    left = sparse.csr_matrix(network - csgraph.maximum_flow(network, count, count + 1).flow)
    left.eliminate_zeros()
    reached = csgraph.breadth_first_order(left.T.tocsr(), count + 1, return_predecessors=False)
    assert set(np.flatnonzero(found)) == set(reached) - {count + 1}


def test_large_cuts_solved_in_bands_stay_near_the_best(monkeypatch):
    from kwatra.cut import minimum as cut

    rng = np.random.default_rng(0)
    shape = (24, 26)
    choice = np.full(shape, FREE)
    choice[:, 0], choice[:, -1] = KEEP, TAKE
    pairs = []
    for axis in range(2):
        less = tuple(n - (d == axis) for d, n in enumerate(shape))
        cost = rng.integers(1, 100, less)
        pairs.append((np.zeros_like(cost), cost, cost))

    def cost_of(take):
        return sum(int(s.sum()) for s in seams_after(choice, take, pairs))

    exact = cost_of(best_cut(choice, pairs))
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 150)
    banded = cost_of(best_cut(choice, pairs))
    assert exact <= banded <= 1.5 * exact


@pytest.mark.parametrize("seed", range(12))
def test_with_a_cost_of_taking_the_cut_is_still_the_best_of_all_labelings(seed):
    rng = np.random.default_rng(seed)
    choice, pairs = random_problem(rng, (3, 4))
    taking = rng.integers(-80, 80, choice.shape)

    def cost_of(take):
        return sum(int(s.sum()) for s in seams_after(choice, take, pairs)) + int(taking[take & (choice == FREE)].sum())

    free = np.argwhere(choice == FREE)
    every = []
    for taken in itertools.product([False, True], repeat=len(free)):
        take = choice == TAKE
        take[tuple(free.T)] = taken
        every.append(cost_of(take))
    take = best_cut(choice, pairs, taking)
    assert cost_of(take) == min(every)
    assert take[choice == TAKE].all()
    assert not take[(choice == KEEP) | (choice == VOID)].any()
    assert cost_of(best_cut(choice, pairs)) >= min(every)


def test_taking_alone_decides_where_there_are_no_seams():
    choice = np.full((4, 5), FREE)
    zero = [np.zeros((3, 5), int), np.zeros((4, 4), int)]
    taking = np.random.default_rng(0).integers(-9, 10, (4, 5))
    assert (best_cut(choice, [(z, z, z) for z in zero], taking=taking) == (taking < 0)).all()
