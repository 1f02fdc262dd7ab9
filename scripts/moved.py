"""Elements that a flow moves exactly: each as a whole, upright, to where the flow takes its center.

That is what a flowing texture is to look like whose elements keep their shape, size and orientation (thesis section
6.2), and a bound: where elements come to overlap, one hides a part of the other however they are made.
"""

from collections.abc import Iterator

import numpy as np
from scipy import ndimage

import flow

Shape = tuple[int, int]


def exactly_moved(numbers: np.ndarray, field: flow.Field, shape: Shape, at: list[int]) -> Iterator[np.ndarray]:
    """Where each pixel of a frame (H, W) comes from, by flat places in a larger picture around the first frame.

    numbers (S, S): of the elements in that picture, 0 for the ground. at: the frames that are asked for, ascending. Of
    two elements that overlap that is seen which the pixel is deeper in. Elements from beyond the picture are missing.
    """
    first = np.array([(large - small) // 2 for large, small in zip(numbers.shape, shape, strict=True)])
    boxes = {k: box for k, box in enumerate(ndimage.find_objects(numbers), 1) if box is not None}
    begin = np.array(ndimage.center_of_mass(numbers > 0, numbers, list(boxes)))
    now = begin.copy()
    for number in range(max(at) + 1):
        if number in at:
            drawn = _drawn(numbers, boxes, np.rint(now - begin).astype(int))
            yield drawn[first[0] : first[0] + shape[0], first[1] : first[1] + shape[1]]
        x, y = field(number, shape).numpy()
        places = (now - first).T
        now += np.stack([ndimage.map_coordinates(v, places, order=1, mode="nearest") for v in (y, x)], 1)


def _drawn(numbers: np.ndarray, boxes: dict[int, tuple[slice, ...]], offsets: np.ndarray) -> np.ndarray:
    """The source (S, S) of a picture in which each element lies so far from its place; the ground's is one of its."""
    source = np.full(numbers.shape, np.flatnonzero(numbers == 0)[0])
    deep = np.zeros(numbers.shape)
    for (element, box), offset in zip(boxes.items(), offsets, strict=True):
        depth = ndimage.distance_transform_edt(np.pad(numbers[box] == element, 1))[1:-1, 1:-1]
        there = np.argwhere(depth > 0)
        here = there + [line.start for line in box] + offset
        shown = ((here >= 0) & (here < numbers.shape)).all(1)
        (y, x), depth = here[shown].T, depth[tuple(there[shown].T)]
        above = depth > deep[y, x]
        deep[y[above], x[above]] = depth[above]
        flat = np.ravel_multi_index(tuple((here[shown] - offset)[above].T), numbers.shape)
        source[y[above], x[above]] = flat
    return source
