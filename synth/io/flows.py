"""Flow in and out of files: Middlebury .flo, KITTI 16-bit .png, and NumPy .npy and .npz, steady or in time."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from flow import NAMES, Field, filled, named, sampled
from flow.checks import check_vectors
from kwatra.base import InputError
from synth.io.flow_formats import ENCODERS, READERS, UNKNOWN
from synth.io.outputs import Writer, bytes_writer, check_writable, write_files
from synth.io.unreadable import reading
from synth.words import counted

FLOW_SUFFIXES = tuple(READERS)


@dataclass(frozen=True)
class Recording:
    """A flow file's content.

    flow (2, H, W), or in time (T, 2, H, W), float32, x first, px per frame; 0 where it is not known. known (H, W) or
    (T, H, W): which vectors the file holds.
    """

    flow: Tensor
    known: Tensor

    def filled(self) -> Tensor:
        """The flow with the nearest known vector wherever one is not known, each frame for itself."""
        if self.flow.ndim == 3:
            return filled(self.flow, self.known)
        return torch.stack([filled(flow, known) for flow, known in zip(self.flow, self.known, strict=True)])

    def field(self, speed: float | None = None, resample: bool = False) -> Field:
        """The field of the filled flow; speed and resample as of `field_of`."""
        return sampled(self.filled(), resample, speed)


def read_flow(path: str | Path) -> Recording:
    """Read a flow file; what it is, its ending says.

    Raises InputError if it is missing, cut short, of another format, holds NaN, or knows no vector of a frame.
    """
    path = Path(path)
    if path.suffix.lower() not in FLOW_SUFFIXES:
        raise InputError(
            f"{path} has an ending that no flow file has; give one ending with {' or '.join(FLOW_SUFFIXES)}"
        )
    with reading(path, "a flow file"):
        vectors = READERS[path.suffix.lower()](path)
    bad = int(np.isnan(vectors).any(-3).sum())
    if bad:
        raise InputError(f"{path} has {counted(bad, 'vector')} of NaN; write 1e10 for what is not known, or mend them")
    flow = torch.from_numpy(np.array(vectors, np.float32))
    known = (flow.abs() <= UNKNOWN).all(-3)
    if not bool(known.flatten(-2).any(-1).all()):
        where = "holds no vector that is known" if flow.ndim == 3 else "has a frame without a vector that is known"
        raise InputError(f"{path} {where}; at least one is needed, whose neighbors then move as it does")
    return Recording(torch.where(known.unsqueeze(-3), flow, 0.0), known)


def field_of(text: str | Path, speed: float | None = None, resample: bool = False) -> Field:
    """The field that a text names (see `flow.named`), or that of a flow file, unknown vectors the nearest known ones.

    speed: px per frame of the fastest pixel (default: 2, a file's own). resample: stretch a file's flow over frames of
    another size. Raises InputError for what is neither, and as `read_flow` does.
    """
    if Path(text).suffix.lower() in FLOW_SUFFIXES:
        return read_flow(text).field(speed, resample)
    if str(text).partition(":")[0] not in NAMES:
        raise InputError(
            f"{str(text)!r} names no flow; give one of {', '.join(NAMES)}, "
            f"or a file ending with {', '.join(FLOW_SUFFIXES)}"
        )
    return named(str(text), speed)


def write_flow(path: str | Path, flow: Tensor, known: Tensor | None = None, overwrite: bool = False) -> None:
    """Write a flow (2, H, W), or in .npy and .npz (T, 2, H, W), in the format that the ending of `path` names.

    known (H, W) or (T, H, W): False where a vector is not known. A .png rounds to 1/64 px.

    Raises InputError if the format cannot hold the flow, the file exists and `overwrite` is not set, or it cannot be
    written; it is then as it was.
    """
    path = Path(path)
    check_flow_output(path, overwrite)
    write_files({path: flow_writer(path, flow, known)}, overwrite)


def check_flow_output(path: Path, overwrite: bool) -> None:
    """Refuse, before any work, a flow file that could not be written."""
    if path.suffix.lower() not in FLOW_SUFFIXES:
        raise InputError(f"{path} has an ending that no flow file has; end it with {' or '.join(FLOW_SUFFIXES)}")
    check_writable(path, overwrite)


def flow_writer(path: Path, flow: Tensor, known: Tensor | None = None) -> Writer:
    """What writes a flow in the format that the ending of `path` names; see `write_flow`."""
    suffix = path.suffix.lower()
    frames = flow[None] if flow.ndim == 3 else flow
    if frames.ndim != 4 or not len(frames) or frames.shape[1] != 2:
        raise InputError(f"flows have shape {tuple(flow.shape)}; give (2, H, W), or (T, 2, H, W) in time")
    if flow.ndim == 4 and suffix in (".flo", ".png"):
        raise InputError(f"{path} cannot hold a flow in time; end it with .npy or .npz")
    if known is None:
        known = torch.ones_like(flow.select(-3, 0), dtype=torch.bool)
    elif known.dtype != torch.bool or known.shape != flow.select(-3, 0).shape:
        raise InputError(
            f"what is known has shape {tuple(known.shape)} and type {known.dtype}; give booleans of the flow's size"
        )
    vectors = torch.where(known.unsqueeze(-3), flow, 0.0).detach().float().cpu()
    for frame in vectors[None] if vectors.ndim == 3 else vectors:
        check_vectors(frame)
    data = ENCODERS[suffix](path, vectors.numpy(), known.cpu().numpy())
    return bytes_writer(data)
