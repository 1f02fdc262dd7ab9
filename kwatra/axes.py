"""What differs between images (two axes) and videos (three): torch's functions by number of axes, and resolutions."""

import torch.nn.functional as F

CONVOLUTION = {2: F.conv2d, 3: F.conv3d}
AVERAGE = {2: F.avg_pool2d, 3: F.avg_pool3d}
LARGEST = {2: F.max_pool2d, 3: F.max_pool3d}


def factors_of(factor: int, axes: int) -> tuple[int, ...]:
    """A resolution's factor per axis: time, the first of three axes, keeps its resolution (thesis 5.5)."""
    return (1,) * (axes - 2) + (factor,) * 2
