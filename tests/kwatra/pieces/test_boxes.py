import numpy as np

from kwatra.pieces.boxes import Box


def test_boxes_have_in_common_what_lies_in_both():
    assert Box((-2, 3), (6, 4)).within(Box((0, 0), (10, 5))) == Box((0, 3), (4, 2))
    assert Box((0, 0), (2, 2)).within(Box((5, 0), (2, 2))).extent == (0, 2)


def test_a_box_is_found_in_one_that_holds_it() -> None:
    around, inner = Box((-1, 4), (6, 5)), Box((2, 5), (2, 3))
    rows, columns = np.meshgrid(np.arange(-1, 5), np.arange(4, 9), indexing="ij")
    part = around.part(inner)
    np.testing.assert_array_equal(np.unique(rows[part]), [2, 3])
    np.testing.assert_array_equal(np.unique(columns[part]), [5, 6, 7])
