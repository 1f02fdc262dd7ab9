import numpy as np

from kwatra.base.spans import box_sums, span_sums


def test_span_sums_are_those_of_every_combination_of_spans():
    values = np.random.default_rng(0).random((2, 5, 7))
    rows, columns = (np.array([0, 2, 5]), np.array([3, 2, 5])), (np.array([1, 0]), np.array([7, 4]))
    sums = span_sums(values, [rows, columns])
    assert sums.shape == (2, 3, 2)
    for i, (top, bottom) in enumerate(zip(*rows, strict=True)):
        for j, (left, right) in enumerate(zip(*columns, strict=True)):
            assert np.allclose(sums[:, i, j], values[:, top:bottom, left:right].sum((1, 2)))


def test_box_sums_are_those_of_every_box_that_fits():
    values = np.random.default_rng(0).integers(0, 9, (6, 5)).astype(np.uint8)
    sums = box_sums(values, (4, 2))
    assert np.array_equal(sums, [[values[y : y + 4, x : x + 2].sum() for x in range(4)] for y in range(3)])
