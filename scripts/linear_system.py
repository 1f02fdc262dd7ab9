"""A rival: linear dynamic systems (Doretto, Chiuso, Wu and Soatto, *Dynamic Textures*, IJCV 2003).

A frame is y = C x + mean, the columns of C being the leading principal components of the clip's frames, and the state x
steps by regression and noise, x' = A x + w, w ~ N(0, Q). C, A and Q are had in closed form, by one singular value
decomposition and one least-squares fit. The frames are new and never end, but they are blends of the clip's.
"""

import numpy as np
import torch
from torch import Tensor

COMPONENTS = 20
"""Of a clip with at least twice as many frames; more of them follow a short clip's noise."""

STABLE = 0.999
"""Largest modulus of an eigenvalue of A: above 1 the state would grow without bounds, as fits to short clips do."""


def linear_system(clip: Tensor, frames: int, seed: int = 0) -> Tensor:
    """`frames` new frames (C, frames, H, W) of a clip (C, T, H, W), T at least 4; they begin with the clip's first."""
    generator = np.random.default_rng(seed)
    shape = clip.transpose(0, 1).shape
    observed = clip.transpose(0, 1).flatten(1).double().numpy()
    mean = observed.mean(0)
    left, scale, components = np.linalg.svd(observed - mean, full_matrices=False)
    count = max(1, min(COMPONENTS, shape[0] // 2, int((scale > 1e-6 * scale[0]).sum())))
    states = left[:, :count] * scale[:count]
    step = np.linalg.lstsq(states[:-1], states[1:], rcond=None)[0]
    step /= max(1.0, np.abs(np.linalg.eigvals(step)).max() / STABLE)
    noise = np.atleast_2d(np.cov((states[1:] - states[:-1] @ step).T))
    spread, axes = np.linalg.eigh(noise)
    root = np.sqrt(spread.clip(0)) * axes
    state, made = states[0], [states[0]]
    for _ in range(frames - 1):
        state = state @ step + root @ generator.standard_normal(count)
        made.append(state)
    video = np.stack(made) @ components[:count] + mean
    return torch.from_numpy(video).float().reshape(frames, *shape[1:]).transpose(0, 1).clamp(0, 1).contiguous()
