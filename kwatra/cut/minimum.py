"""Patch fitting by minimum cut (thesis section 3.1), in any number of dimensions.

Every pixel either keeps its old patch (0) or takes the new one (1). A pair of neighbors (s, t) costs

    keep, keep: a = M(s, t, A_s, A_t)     an old seam remembered (0 where both come from one patch)
    keep, take: b = M(s, t, A_s, B)       take, keep: c = M(s, t, B, A_t)       take, take: 0

The thesis hangs a seam node between s and t, with arcs b and c to the pixels and a to the new patch. Here that node is
eliminated: the same minimum is reached by arcs s -> t and t -> s that sum to b + c - a, and the rest on the arcs to the
terminals; one node and two arcs fewer per old seam. With a metric, b + c >= a always. With the cost M' it may fail, and
then a counts as b + c in the cut, which is just what the seam node does; an accepted cut still never costs more than
keeping everything. Constraint arcs are nodes that are not free: their choice is folded into their neighbors' terminals.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from types import ModuleType

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from kwatra.cut.bands import along, solve_in_bands

KEEP, TAKE, FREE, VOID = 0, 1, 2, 3
"""What may happen to a pixel: it keeps its patch, takes the new one, may do either, or is empty and stays so."""

MOST_AT_ONCE = 100_000
"""Cuts over more free pixels than this are solved coarse to fine (coarsecut.py): faster, and bounded in memory. In
three dimensions a third of it is the limit, for there a flow takes far longer."""

Costs = tuple[np.ndarray, np.ndarray, np.ndarray]


def best_cut(
    state: np.ndarray,
    pairs: Sequence[Costs],
    use_maxflow: bool | None = None,
    taking: np.ndarray | None = None,
    most: int | None = None,
) -> np.ndarray:
    """Which pixels take the new patch in the cheapest labeling; boolean, shaped as `state`.

    `state`: KEEP, TAKE, FREE or VOID per pixel. `pairs`: per axis the integer costs (a, b, c) of the pairs
    (p, p + 1 along the axis), one shorter than `state` along that axis. `taking`: what a pixel costs more when it
    takes than when it keeps, integer, shaped as `state`. Of several cheapest labelings the one that takes fewest
    pixels (with PyMaxflow, any). `use_maxflow`: whether PyMaxflow solves; None for yes if installed. `most`: cuts over
    more free pixels than this are solved coarse to fine; by default MOST_AT_ONCE, in three dimensions a third of it.
    """
    free = state == FREE
    unary, arcs = _energy(state, pairs)
    if taking is not None:
        unary += taking
    take = state == TAKE
    if (unary[free] < 0).any():
        solve = _solve_maxflow if (maxflow() is not None if use_maxflow is None else use_maxflow) else _solve_scipy
        default = MOST_AT_ONCE if state.ndim < 3 else MOST_AT_ONCE // 3
        take[free] = solve_in_bands(unary, arcs, free, solve, default if most is None else most)
    return take


def seams_after(state: np.ndarray, take: np.ndarray, pairs: Sequence[Costs]) -> list[np.ndarray]:
    """The cost of each pair, per axis, once the pixels in `take` have taken the new patch."""
    result = []
    for axis, (a, b, c) in enumerate(pairs):
        p, q = along(axis, None, -1, state.ndim), along(axis, 1, None, state.ndim)
        filled = (state != VOID)[p] & (state != VOID)[q]
        cost = np.where(take[p], np.where(take[q], 0, c), np.where(take[q], b, a))
        result.append(np.where(filled, cost, 0).astype(np.int32))
    return result


def _energy(state: np.ndarray, pairs: Sequence[Costs]) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Terminal weights (cost of taking minus cost of keeping) and, per axis, the arcs p -> q and q -> p."""
    unary = np.zeros(state.shape, np.int64)
    arcs = []
    for axis, (a, b, c) in enumerate(pairs):
        p, q = along(axis, None, -1, state.ndim), along(axis, 1, None, state.ndim)
        sp, sq = state[p], state[q]
        fp, fq = sp == FREE, sq == FREE
        both = fp & fq
        old = np.minimum(a, b + c)
        # Any split of -a between the two terminals is exact; the even one leaves the smallest flow to be found.
        up = np.clip(-(old // 2), -b, c - old)
        uq = -old - up
        unary[p] += np.where(both, up, np.where(fp & (sq == KEEP), c - a, np.where(fp & (sq == TAKE), -b, 0)))
        unary[q] += np.where(both, uq, np.where(fq & (sp == KEEP), b - a, np.where(fq & (sp == TAKE), -c, 0)))
        arcs.append((np.where(both, b - old - uq, 0), np.where(both, c - old - up, 0)))
    return unary, arcs


def _slots(values: np.ndarray, axis: int, forward: bool, shape: tuple[int, ...]) -> np.ndarray:
    """Pair values along an axis as one value per pixel: the pair ahead of it, or the pair behind it."""
    whole = np.zeros(shape, values.dtype)
    whole[along(axis, None, -1, len(shape)) if forward else along(axis, 1, None, len(shape))] = values
    return whole


def _neighbor_table(
    arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Per free pixel its arcs in ascending order of neighbor: (capacity, neighbor, whether the arc exists)."""
    node = np.full(free.shape, -1, np.int32)
    node[free] = np.arange(np.count_nonzero(free), dtype=np.int32)
    capacity, column, present = [], [], []
    order = [(axis, False) for axis in range(free.ndim)] + [(axis, True) for axis in reversed(range(free.ndim))]
    for axis, forward in order:
        ahead, back = arcs[axis]
        other = np.take(node, range(1, free.shape[axis]) if forward else range(free.shape[axis] - 1), axis)
        capacity.append(_slots(ahead if forward else back, axis, forward, free.shape)[free])
        column.append(_slots(other, axis, forward, free.shape)[free])
        present.append(_slots((ahead > 0) | (back > 0), axis, forward, free.shape)[free])
    return np.stack(capacity, 1), np.stack(column, 1), np.stack(present, 1)


def _network(unary: np.ndarray, arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray) -> sparse.csr_array:
    """The flow network: free pixels, then the terminal of the old patches, then that of the new one."""
    weight = unary[free]
    count = len(weight)
    capacity, column, present = _neighbor_table(arcs, free)
    terminal = np.where(weight > 0, count, count + 1).astype(np.int32)
    capacity = np.column_stack([capacity, np.where(weight < 0, -weight, 0)])
    column = np.column_stack([column, terminal])
    present = np.column_stack([present, weight != 0])
    old, new = np.flatnonzero(weight > 0), np.flatnonzero(weight < 0)
    data = np.concatenate([capacity[present], weight[old], np.zeros(len(new), np.int64)])
    if data.max(initial=0) > 2**29:
        raise OverflowError("the capacities of a cut do not fit 32 bits: a seam cost is out of its range")
    columns = np.concatenate([column[present], old, new]).astype(np.int32)
    lengths = np.concatenate([[0], present.sum(1), [len(old), len(new)]])
    return sparse.csr_array(
        (data.astype(np.int32), columns, np.cumsum(lengths).astype(np.int32)), (count + 2, count + 2)
    )


def _solve_scipy(unary: np.ndarray, arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray) -> np.ndarray:
    network = _network(unary, arcs, free)
    count = network.shape[0] - 2
    # A flow of scipy's names the same arcs as the network, so what is left of each arc is one subtraction.
    flow = csgraph.maximum_flow(sparse.csr_matrix(network), count, count + 1).flow
    left = sparse.csr_array(network - flow)
    left.eliminate_zeros()
    reached = csgraph.breadth_first_order(left.T.tocsr(), count + 1, return_predecessors=False)
    take = np.zeros(count + 2, bool)
    take[reached] = True
    return take[:count]


def _solve_maxflow(unary: np.ndarray, arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray) -> np.ndarray:
    library = maxflow()
    assert library is not None
    weight = unary[free]
    capacity, column, present = _neighbor_table(arcs, free)
    graph = library.Graph[int](len(weight), int(present.sum()))
    nodes = graph.add_grid_nodes((len(weight),))
    dims = free.ndim
    back = {axis: 2 * dims - 1 - axis for axis in range(dims)}
    for axis in range(dims):
        ahead = present[:, back[axis]]
        start, end = np.flatnonzero(ahead), column[ahead, back[axis]]
        graph.add_edges(start, end, capacity[start, back[axis]], capacity[end, axis])
    graph.add_grid_tedges(nodes, np.maximum(weight, 0), np.maximum(-weight, 0))
    graph.maxflow()
    return np.asarray(graph.get_grid_segments(nodes), bool)


def maxflow() -> ModuleType | None:
    """PyMaxflow if it is installed: three to nine times faster, but GPL, so never required."""
    if importlib.util.find_spec("maxflow") is None:
        return None
    import maxflow

    return maxflow
