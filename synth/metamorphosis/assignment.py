"""Which element becomes which: least summed squared way of the centroids (Liu et al. 2002, 4.3, equations 7 to 9)."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def assigned(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The numbers of the elements with centroids a (n, 2) and b (n', 2) that are partners: min(n, n') of each.

    The virtual elements of the paper, which make both equally many, cost nothing wherever they go. So leaving them
    out, and with them their partners, is the same assignment.
    """
    ways = np.square(a[:, None] - b[None]).sum(2)
    return linear_sum_assignment(ways)
