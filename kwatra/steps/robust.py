"""The robust loss of the texture energy and its IRLS weight, side by side (thesis section 5.2).

The energy of a window at distance d is rho(d) = d^r; iteratively re-weighted least squares minimizes it by solving
sum_p weight_p * d_p^2 again and again with weight = d^(r-2), which is (2/r) times the derivative of rho by d^2.
Distances are rms per pixel and channel, so a floor of 1/1000 of the color range keeps perfect matches finite.
"""

from torch import Tensor

from kwatra.base import power

FLOOR = 1e-6
"""What is added to a squared distance (colors in [0, 1]), so that the weight of a copy is finite: a guard."""


def rho(squared: Tensor, r: float) -> Tensor:
    """Robust energy d^r of squared distances d^2 >= 0, any shape; r in (0, 2]."""
    return power(squared + FLOOR, r / 2)


def weight(squared: Tensor, r: float) -> Tensor:
    """IRLS weight d^(r-2) of squared distances d^2 >= 0, any shape; r in (0, 2]."""
    return power(squared + FLOOR, r / 2 - 1)
