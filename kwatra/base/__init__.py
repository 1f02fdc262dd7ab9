"""What everything stands on: the one error, axes, sums, derivatives, linear systems, seeds, sizes, tensors, threads."""

from kwatra.base.axes import AVERAGE, CONVOLUTION, LARGEST, coarse_shape, enlarged, factors_of, resized, running
from kwatra.base.derivatives import constant, differentiable
from kwatra.base.errors import InputError, check_mask
from kwatra.base.membrane import every_pair, membrane
from kwatra.base.nearest import continued, nearest_known, nearest_owned
from kwatra.base.reductions import atan2, mean, over_channels, power, principal_axes, product, total
from kwatra.base.regions import joined
from kwatra.base.resampling import turned
from kwatra.base.seeds import generator_of, whole_seed
from kwatra.base.sizes import is_whole, whole_sizes
from kwatra.base.solver import Solution, conjugate_gradients
from kwatra.base.spans import box_sums
from kwatra.base.tensors import device_of, floats_of, tensor_of
from kwatra.base.threads import by_one_thread, by_our_threads, even_ranges, shared, threads_shared

__all__ = [
    "AVERAGE",
    "CONVOLUTION",
    "LARGEST",
    "InputError",
    "Solution",
    "atan2",
    "box_sums",
    "by_one_thread",
    "by_our_threads",
    "check_mask",
    "coarse_shape",
    "conjugate_gradients",
    "constant",
    "continued",
    "device_of",
    "differentiable",
    "enlarged",
    "even_ranges",
    "every_pair",
    "factors_of",
    "floats_of",
    "generator_of",
    "is_whole",
    "joined",
    "mean",
    "membrane",
    "nearest_known",
    "nearest_owned",
    "over_channels",
    "power",
    "principal_axes",
    "product",
    "resized",
    "running",
    "shared",
    "tensor_of",
    "threads_shared",
    "total",
    "turned",
    "whole_seed",
    "whole_sizes",
]
