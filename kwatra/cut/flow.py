"""Maximum flow by two search trees that are kept from one augmenting path to the next (Boykov and Kolmogorov 2004).

The network is a grid: every node has the same few directions, direction d leads back as `back[d]`. Nodes hang on one of
two terminals each. The tree S grows from the source and the tree T from the sink along arcs that are not full; where
they touch, a path is filled, and the nodes it cuts off look for a new parent, or become free. Each node remembers how
far it is from its terminal and when that was checked last: so trees stay short.

This module is compiled by numba when first used, so it is imported where a cut is solved.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted

FREE, SOURCE, SINK = 0, 1, 2
"""The tree a node belongs to."""

TERMINAL, NONE, ORPHAN = -2, -1, -3
"""What a node's parent is when it is no neighbor."""

FAR = 1 << 30
"""More steps than any path has."""


def sink_side(weight: np.ndarray, capacity: np.ndarray, neighbor: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Which nodes (N,) lie on the sink's side of the minimum cut that has fewest of them there.

    weight (N,) integers: above 0 the capacity from the source, below 0 that to the sink. capacity (N, D): of each
    node's arcs; neighbor (N, D): where they lead, -1 for nowhere; back (D,): the direction that leads back.
    """
    left = np.ascontiguousarray(weight, dtype=np.int64).copy()
    return _trees(left, np.ascontiguousarray(capacity, np.int64).copy(), neighbor.astype(np.int32), back) == SINK


@jitted
def _trees(left: Any, cap: Any, near: Any, back: Any) -> Any:
    """Fill the network; the trees (N,) at the end. `left` and `cap` become what is left."""
    count = len(left)
    tree, parent = np.zeros(count, np.int8), np.full(count, NONE, np.int8)
    seen, far = np.zeros(count, np.int64), np.zeros(count, np.int64)
    queue, queued = np.empty(count + 1, np.int32), np.zeros(count, np.bool_)
    orphans = np.empty(count + 1, np.int32)
    counters = np.zeros(3, np.int64)  # head and tail of the queue, time
    for i in range(count):
        if left[i] != 0:
            tree[i], parent[i], far[i] = (SOURCE if left[i] > 0 else SINK), TERMINAL, 1
            _activate(i, queue, queued, counters)
    while counters[0] != counters[1]:
        i = queue[counters[0]]
        while parent[i] != NONE:
            counters[2] += 1
            d = _grown(i, tree, parent, cap, near, back, seen, far, queue, queued, counters)
            if d < 0:
                break
            if tree[i] == SOURCE:
                orphaned = _filled(i, d, left, cap, near, back, parent, orphans)
            else:
                orphaned = _filled(near[i, d], back[d], left, cap, near, back, parent, orphans)
            _adopted(orphaned, orphans, tree, parent, cap, near, back, seen, far, queue, queued, counters)
        counters[0] = (counters[0] + 1) % len(queue)
        queued[i] = False
    return tree


@jitted
def _activate(i: Any, queue: Any, queued: Any, counters: Any) -> None:
    if not queued[i]:
        queued[i] = True
        queue[counters[1]] = i
        counters[1] = (counters[1] + 1) % len(queue)


@jitted
def _open(i: Any, d: Any, j: Any, tree: Any, cap: Any, back: Any) -> Any:
    """Whether the arc between i and its neighbor j lets anything through, away from i's terminal's side."""
    return cap[i, d] > 0 if tree == SOURCE else cap[j, back[d]] > 0


@jitted
def _grown(
    i: Any, tree: Any, parent: Any, cap: Any, near: Any, back: Any, seen: Any, far: Any, queue: Any, queued: Any,
    counters: Any,
) -> Any:  # fmt: skip
    """Let i's tree take its free neighbors; the direction in which it touches the other tree, or -1."""
    for d in range(near.shape[1]):
        j = near[i, d]
        if j < 0 or not _open(i, d, j, tree[i], cap, back):
            continue
        if parent[j] == NONE:
            tree[j], parent[j], seen[j], far[j] = tree[i], back[d], seen[i], far[i] + 1
            _activate(j, queue, queued, counters)
        elif tree[j] != tree[i]:
            return d
        elif seen[j] <= seen[i] and far[j] > far[i]:
            parent[j], seen[j], far[j] = back[d], seen[i], far[i] + 1
    return -1


@jitted
def _filled(i: Any, d: Any, left: Any, cap: Any, near: Any, back: Any, parent: Any, orphans: Any) -> Any:
    """Fill the path through the arc d of i, which leads from the tree S to the tree T; how many nodes it cuts off."""
    j = near[i, d]
    most = cap[i, d]
    a = i
    while parent[a] != TERMINAL:
        up = near[a, parent[a]]
        most = min(most, cap[up, back[parent[a]]])
        a = up
    most = min(most, left[a])
    b = j
    while parent[b] != TERMINAL:
        most = min(most, cap[b, parent[b]])
        b = near[b, parent[b]]
    most = min(most, -left[b])
    cap[i, d] -= most
    cap[j, back[d]] += most
    count = _branch_filled(i, most, SOURCE, left, cap, near, back, parent, orphans, 0)
    return _branch_filled(j, most, SINK, left, cap, near, back, parent, orphans, count)


@jitted
def _branch_filled(
    a: Any, most: Any, tree: Any, left: Any, cap: Any, near: Any, back: Any, parent: Any, orphans: Any, count: Any
) -> Any:
    """Fill one side of a path, from the node a to its tree's terminal; `count` and how many more nodes are cut off."""
    while True:
        p = parent[a]
        if p == TERMINAL:
            left[a] -= most if tree == SOURCE else -most
            full = left[a] == 0
        else:
            up = near[a, p]
            cap[up, back[p]] -= most if tree == SOURCE else -most
            cap[a, p] += most if tree == SOURCE else -most
            full = cap[up, back[p]] == 0 if tree == SOURCE else cap[a, p] == 0
        if full:
            parent[a] = ORPHAN
            orphans[count] = a
            count += 1
        if p == TERMINAL:
            return count
        a = up


@jitted
def _rooted(k: Any, parent: Any, near: Any, seen: Any, far: Any, now: Any) -> Any:
    """How many steps k is from its tree's terminal, FAR if it hangs on an orphan."""
    steps = 0
    while True:
        if seen[k] == now:
            return steps + far[k]
        p = parent[k]
        steps += 1
        if p == TERMINAL:
            seen[k], far[k] = now, 1
            return steps
        if p < 0:
            return FAR
        k = near[k, p]


@jitted
def _adopted(
    count: Any, orphans: Any, tree: Any, parent: Any, cap: Any, near: Any, back: Any, seen: Any, far: Any, queue: Any,
    queued: Any, counters: Any,
) -> None:  # fmt: skip
    """Find every orphan a parent in its tree, the nearest to the terminal, or set it and its children free."""
    now = counters[2]
    while count > 0:
        count -= 1
        i = orphans[count]
        best, least = NONE, FAR
        for d in range(near.shape[1]):
            j = near[i, d]
            # the arc toward i for S, away from it for T
            if j < 0 or tree[j] != tree[i] or not _open(j, back[d], i, tree[i], cap, back):
                continue
            steps = _rooted(j, parent, near, seen, far, now)
            if steps < FAR:
                if steps < least:
                    best, least = d, steps
                k = j
                while seen[k] != now:
                    seen[k], far[k] = now, steps
                    steps -= 1
                    k = near[k, parent[k]]
        if best != NONE:
            parent[i], seen[i], far[i] = best, now, least + 1
            continue
        for d in range(near.shape[1]):
            j = near[i, d]
            if j < 0 or tree[j] != tree[i] or parent[j] == NONE:
                continue
            if _open(j, back[d], i, tree[i], cap, back):
                _activate(j, queue, queued, counters)
            if parent[j] >= 0 and near[j, parent[j]] == i:
                parent[j] = ORPHAN
                orphans[count] = j
                count += 1
        tree[i], parent[i] = FREE, NONE
