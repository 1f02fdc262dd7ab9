"""What blocks cost that may be laid, and which are picked, in compiled loops.

They are few and long: threads that share blocks then seldom wait for the interpreter. Arrays are of boxes (b,) of one
extent, over the blocks (n,) that may be laid in each.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.spanloops import sum_boxes
from kwatra.pieces.choosing.comparing import compare, sum_near
from kwatra.pieces.loops import copy_into, quantile


@jitted
def attain(mismatches: Any, valid: Any, same: Any, good: Any, floor: Any) -> Any:
    """The disagreement that a texture affords, given that of all blocks (n,): what others are measured by.

    It is the geometric mean of the least, and of what a good share stay below; neither counts less than `floor`. Of
    blocks that are valid and do not merely continue what is there (`same` is 0), or else of all valid ones.
    """
    every, blocks = np.empty(len(mismatches)), 0
    for fresh in (True, False):
        for i in range(len(every)):
            if valid[i] and (same[i] == 0 or not fresh):
                every[blocks] = mismatches[i]
                blocks += 1
        if blocks > 0:
            break
    some = every[:blocks]
    return np.sqrt(max(some.min(), floor) * max(quantile(some, good), floor))


@jitted
def wear(used: Any, spans: Any, pixels: Any, usage: Any, size: Any) -> Any:
    """What blocks cost (n,) for how often their pixels were used (1, A, B, C): usage times more than all on average.

    spans: of each axis the first pixels under blocks, and those after the last; pixels (n,): how many there are; size:
    how many there are of all.
    """
    worn, mean = sum_boxes(used, spans[0], spans[1]).ravel(), used.sum() / size
    for i in range(len(worn)):
        worn[i] = usage * (worn[i] / pixels[i] - mean)
    return worn


@jitted
def weigh(
    compared: Any, charges: Any, valid: Any, same: Any, some: Any, good: Any, floor: Any, gaps: Any, most: Any,
    acceptable: Any, tolerance: Any, luck: Any, costs: Any, picked: Any,
) -> None:  # fmt: skip
    """Set what blocks cost (b, n) in boxes, and pick some (`pick_each`).

    They cost infinitely much where they are not `valid` (b, n), or out of step where only those in step may be laid.

    compared: how little they agree in colors, and, in a second image, in where gaps lie (`Compared`). Either is counted
    in what can be attained (`attain`, with `good` and `floor`). gaps: how much the second counts beside the first,
    where `some` (b,) is known. charges: what else they cost (`Charges`); same (b, n): as of `charge_shown`.
    """
    boxes, images, blocks = len(costs), compared.raw.shape[1], costs.shape[1]
    found, near = np.zeros((boxes, images, blocks)), np.empty((boxes, blocks if len(charges.around.starts) > 0 else 0))
    if len(compared.raw) > 0:
        compare(compared, valid, found)
    for box in range(len(charges.missed)):
        for i in range(blocks):
            found[box, 0, i] = np.rint((found[box, 0, i] + charges.missed[box, i]) * compared.steps) / compared.steps
    if len(charges.around.starts) > 0:
        sum_near(charges.around, near)
    pixels, away, steps = charges.pixels, charges.away, charges.steps
    worn = wear(charges.used, charges.under, pixels, charges.usage, charges.size)
    shown, cost = np.empty(blocks), np.empty(blocks)
    for box in range(boxes):
        afforded = attain(found[box, 0], valid[box], same[box], good, floor)
        for i in range(blocks):
            charge = away[box, i] if away.shape[1] > 0 else 0.0
            cost[i] = (found[box, 0, i] + charge) / afforded
        if images > 1 and some[box]:
            afforded = attain(found[box, 1], valid[box], same[box], good, floor)
            for i in range(blocks):
                cost[i] = (cost[i] + gaps * (found[box, 1, i] / afforded)) / (1 + gaps)
        charge_shown(worn, near[box], same[box], pixels, charges.again, charges.beside, shown)
        if steps.shape[1] > 0 and some[box]:
            keep_in_step(steps[box], charges.in_step, charges.only, valid[box], shown)
        for i in range(blocks):
            costs[box, i] = cost[i] + shown[i] if valid[box, i] else np.inf
    for further in charges.more:
        for box in range(boxes):
            for i in range(blocks):
                costs[box, i] += further[box, i]
    pick_each(costs, most, acceptable, tolerance, luck, picked)


@jitted
def charge_shown(worn: Any, near: Any, same: Any, pixels: Any, again: Any, beside: Any, cost: Any) -> None:
    """Set what blocks cost (n,) for what was shown before.

    worn (n,): what they cost for how often their pixels were. near (n,): the sums of how near to the box these are
    shown; (0,): nowhere is asked. same (n,): how many pixels only continue a copy; pixels (n,): how many there are.
    again, beside: what a block costs that continues a copy, that is shown right beside.
    """
    for i in range(len(worn)):
        cost[i] = worn[i]
        if len(near) > 0:
            cost[i] += beside / pixels[i] * (near[i] - same[i])
        if same[i] > 0:
            cost[i] += again


@jitted
def keep_in_step(step: Any, most: Any, only: Any, valid: Any, cost: Any) -> None:
    """Add to what blocks cost (n,) for what was shown before what they do for being out of step, `step` (n,).

    What was shown before is no reason to leave the lattice: it counts from the least that it costs among `valid` blocks
    in step, which cost at most so much for that. Of an exemplar of two periods hardly more than one block is, which
    else costs more than one beside it. only: whether no others may be laid, so that they cost infinitely much.
    """
    least = np.inf
    for i in range(len(step)):
        if valid[i] and step[i] <= most:
            least = min(least, cost[i])
    for i in range(len(step)):
        if only and step[i] > most:
            cost[i] = np.inf
        else:
            cost[i] = step[i] + (cost[i] if least == np.inf else max(cost[i] - least, 0.0))


@jitted
def pick_each(costs: Any, most: Any, acceptable: Any, tolerance: Any, luck: Any, picked: Any) -> None:
    """Set the numbers of the blocks that are picked (b, m) for boxes, given all costs (b, n); -1 where there are fewer.

    They are at most so many (b,), of costs that exceed the least by an acceptable amount (`pick`); where it is one, one
    is drawn within a tolerance, as luck (b,) has it (`draw`).
    """
    picked[:] = -1
    for box in range(len(costs)):
        if most[box] == 1:
            picked[box, 0] = draw(costs[box], tolerance, luck[box])
        else:
            copy_into(pick(costs[box], most[box], acceptable), picked[box])


@jitted
def draw(costs: Any, reach: Any, luck: Any) -> Any:
    """The number of a block whose cost (n,) is within `reach` of the least; luck, 0 to 1, says of which."""
    most, count = costs.min() + reach, 0
    for cost in costs:
        count += cost <= most
    left = int(luck * count)
    for i in range(len(costs)):
        if costs[i] <= most:
            if left == 0:
                break
            left -= 1
    return i


@jitted
def pick(costs: Any, most: Any, reach: Any) -> Any:
    """The numbers of at most so many blocks of the least costs (n,), within `reach` of it, the cheapest first."""
    chosen = np.full(most, -1)
    found = 0
    for i in range(len(costs)):
        if found == most and costs[i] >= costs[chosen[most - 1]]:
            continue
        found = min(found + 1, most)
        at = found - 1
        while at > 0 and costs[chosen[at - 1]] > costs[i]:
            chosen[at] = chosen[at - 1]
            at -= 1
        chosen[at] = i
    last = found
    while last > 1 and costs[chosen[last - 1]] > costs[chosen[0]] + reach:
        last -= 1
    return chosen[:last]
