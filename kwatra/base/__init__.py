"""What everything stands on: the one error, axes, sums, linear systems."""

from kwatra.base.axes import AVERAGE, CONVOLUTION, LARGEST, coarse_shape, factors_of, resized
from kwatra.base.errors import InputError
from kwatra.base.reductions import mean, total
from kwatra.base.solver import Solution, conjugate_gradients

__all__ = [
    "AVERAGE",
    "CONVOLUTION",
    "LARGEST",
    "InputError",
    "Solution",
    "coarse_shape",
    "conjugate_gradients",
    "factors_of",
    "mean",
    "resized",
    "total",
]
