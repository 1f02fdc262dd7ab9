"""Sequences whose last frame leads into their first.

The animation is run forward from its first frame, and, for the last stretch, also backward from it: what leads into
the first frame exactly. During that stretch the one turns into the other region by region, each at a time of its own
that moves along with it; the seam between them is a minimum cut in every frame. So the end differs from the rest by a
few more regions renewed per frame, and the join is a pair of frames like any other.
"""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from collections.abc import Iterator
from flow.animation import Frame, Motion, State
from flow.fields import Field
from flow.warps import lookup, pixel_coordinates, warp

