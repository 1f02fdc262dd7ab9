"""What everything stands on: the one error, axes, sums."""

from kwatra.base.axes import AVERAGE, CONVOLUTION, LARGEST, coarse_shape, enlarged, factors_of, resized
from kwatra.base.errors import InputError, check_mask
from kwatra.base.reductions import mean, total

__all__ = [
    "AVERAGE",
    "CONVOLUTION",
    "LARGEST",
    "InputError",
    "check_mask",
    "coarse_shape",
    "enlarged",
    "factors_of",
    "mean",
    "resized",
    "total",
]
