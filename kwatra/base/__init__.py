"""What everything stands on: the one error, axes, sums, seeds, sizes."""

from kwatra.base.axes import AVERAGE, CONVOLUTION, LARGEST, coarse_shape, factors_of, resized
from kwatra.base.errors import InputError
from kwatra.base.reductions import mean, total
from kwatra.base.seeds import generator_of
from kwatra.base.sizes import whole_sizes

__all__ = [
    "AVERAGE",
    "CONVOLUTION",
    "LARGEST",
    "InputError",
    "coarse_shape",
    "factors_of",
    "generator_of",
    "mean",
    "resized",
    "total",
    "whole_sizes",
]
