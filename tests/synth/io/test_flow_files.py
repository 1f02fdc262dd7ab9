"""Flow files come back as they went in, and as others write them; what is broken is refused in a sentence."""

import math
import struct
from collections.abc import Callable
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
import torch
from torch import Tensor

import flow
from kwatra import InputError
from synth import field_of, read_flow, write_flow

SHAPE = (7, 11)


def steady() -> Tensor:
    """A flow whose values a KITTI file holds exactly."""
    steps = torch.randint(-200, 201, (2, *SHAPE), generator=torch.Generator().manual_seed(0))
    return steps / 64


def known() -> Tensor:
    known = torch.ones(SHAPE, dtype=torch.bool)
    known[2, 3] = known[6, 10] = False
    return known


@pytest.mark.parametrize("suffix", [".flo", ".png", ".npy", ".npz"])
def test_a_flow_and_what_is_unknown_of_it_come_back(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    write_flow(path, torch.where(known(), steady(), torch.nan), known())
    read = read_flow(path)
    assert torch.equal(read.known, known())
    assert torch.equal(read.flow, torch.where(known(), steady(), 0.0))
    assert torch.equal(read.filled(), flow.filled(steady(), known()))
    write_flow(path, steady(), overwrite=True)
    assert torch.equal(read_flow(path).flow, steady())
    assert bool(read_flow(path).known.all())


@pytest.mark.parametrize("suffix", [".npy", ".npz"])
def test_flows_in_time_come_back(tmp_path: Path, suffix: str) -> None:
    flows = torch.stack([steady(), -steady(), 2 * steady()])
    when = torch.stack([known(), ~known(), known()])
    write_flow(tmp_path / f"a{suffix}", flows, when)
    read = read_flow(tmp_path / f"a{suffix}")
    assert torch.equal(read.known, when)
    assert torch.equal(read.flow, torch.where(when[:, None], flows, 0.0))
    assert torch.equal(read.filled()[1], flow.filled(-steady(), ~known()))


def test_a_middlebury_file_is_what_its_definition_says(tmp_path: Path) -> None:
    path = tmp_path / "a.flo"
    path.write_bytes(b"PIEH" + struct.pack("<ii", 2, 1) + struct.pack("<4f", 1.5, -2.0, 1e10, 1e10))
    read = read_flow(path)
    assert read.flow.tolist() == [[[1.5, 0.0]], [[-2.0, 0.0]]]
    assert read.known.tolist() == [[True, False]]
    write_flow(tmp_path / "b.flo", read.flow, read.known)
    assert (tmp_path / "b.flo").read_bytes() == path.read_bytes()


def test_a_kitti_file_is_what_its_definition_says(tmp_path: Path) -> None:
    pixels = np.zeros((1, 2, 3), np.uint16)
    pixels[0, 0] = 2**15 + 96, 2**15 - 128, 1
    pixels[0, 1] = 5, 5, 0
    path = tmp_path / "a.png"
    path.write_bytes(imagecodecs.png_encode(pixels))
    read = read_flow(path)
    assert read.flow.tolist() == [[[1.5, 0.0]], [[-2.0, 0.0]]]
    assert read.known.tolist() == [[True, False]]


@pytest.mark.parametrize("layout", [(0, 1, 2), (1, 2, 0)])
def test_arrays_may_have_their_channels_first_or_last(tmp_path: Path, layout: tuple[int, ...]) -> None:
    np.save(tmp_path / "a.npy", steady().permute(layout).double().numpy())
    assert torch.equal(read_flow(tmp_path / "a.npy").flow, steady())
    np.savez(tmp_path / "b.npz", other=np.zeros(3), flow=steady().permute(layout).numpy())
    assert torch.equal(read_flow(tmp_path / "b.npz").flow, steady())
    np.savez(tmp_path / "c.npz", anything=steady()[None].expand(4, -1, -1, -1).permute(0, *(1 + i for i in layout)))
    assert torch.equal(read_flow(tmp_path / "c.npz").flow, steady().expand(4, -1, -1, -1))


def test_a_simulations_staggered_velocity_goes_straight_in(tmp_path: Path) -> None:
    """x = 3 + column and y = 5 - 2 row, each where a staggered grid knows it."""
    height, width = SHAPE
    grid = np.full((height + 1, width + 1, 2), 77.0, np.float32)
    grid[:height, :, 0] = 3 + np.arange(width + 1) - 0.5
    grid[:, :width, 1] = (5 - 2 * (np.arange(height + 1) - 0.5))[:, None]
    np.savez(tmp_path / "smoke.npz", velocity_staggered=grid / 16)
    read = read_flow(tmp_path / "smoke.npz").flow * 16
    assert read.shape == (2, *SHAPE)
    assert torch.allclose(read[0], (3 + torch.arange(width)).expand(SHAPE).float())
    assert torch.allclose(read[1], (5 - 2 * torch.arange(height))[:, None].expand(SHAPE).float())
    np.savez(tmp_path / "in_time.npz", velocity_staggered=np.stack([grid, 2 * grid]) / 16)
    assert torch.allclose(read_flow(tmp_path / "in_time.npz").flow[1] * 16, 2 * read)
    assert field_of(tmp_path / "smoke.npz", speed=1.0).steady


def flo(*numbers: int, magic: float = 202021.25) -> bytes:
    return struct.pack("<f", magic) + struct.pack("<ii", *numbers[:2]) + bytes(numbers[2])


def saved(save: Callable[..., None], *arrays: np.ndarray, **named: np.ndarray) -> bytes:
    import io

    stream = io.BytesIO()
    save(stream, *arrays, **named)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("a.flo", flo(4, 3, 90), r"a\.flo has 102 bytes, but 108 make a flow of 4x3; get it anew"),
        ("a.flo", flo(4, 3, 97), r"a\.flo has 109 bytes, but 108 make a flow of 4x3"),
        ("a.flo", b"PIEH\0\0", r"a\.flo is cut short, not even its head of 12 bytes is there"),
        ("a.flo", b"", r"a\.flo is cut short"),
        ("a.flo", flo(4, 3, 96, magic=1.0), r"is no Middlebury flow, it does not begin with the number 202021\.25"),
        ("a.flo", flo(-4, 3, 96), r"says that it is -4x3, which no flow is"),
        ("a.png", b"no png", r"a\.png is no PNG that can be read, or is cut short"),
        ("a.png", imagecodecs.png_encode(np.zeros((4, 4, 3), np.uint8)), "holds uint8 pixels .* three channels of 16"),
        ("a.npy", b"\x93NUMPY", r"a\.npy is no NumPy file of numbers, or is cut short"),
        ("a.npy", saved(np.save, np.zeros((2, 9, 9)))[:-8], r"a\.npy is no NumPy file of numbers, or is cut short"),
        ("a.npy", saved(np.save, np.array([{}])), r"a\.npy is no NumPy file of numbers"),
        ("a.npy", saved(np.save, np.zeros((3, 4, 5))), r"holds an array \(3, 4, 5\); a flow is \(2, H, W\)"),
        ("a.npy", saved(np.save, np.zeros((2, 0, 5))), r"holds an array \(2, 0, 5\)"),
        ("a.npy", saved(np.save, np.zeros((2, 4, 5), complex)), "holds complex128; a flow is made of numbers"),
        ("a.npy", saved(np.save, np.full((2, 4, 5), np.nan)), "has 20 vectors of NaN; write 1e10 for what"),
        ("a.npz", saved(np.savez), "holds the arrays none; name the one to read flow or velocity"),
        ("a.npz", saved(np.savez, a=np.zeros(3), b=np.zeros(3)), "holds the arrays a, b; name the one to read flow"),
        ("a.npz", saved(np.savez, v_staggered=np.zeros((4, 5, 3))), r"a staggered grid is \(H \+ 1, W \+ 1, 2\)"),
        ("a.tif", b"", r"a\.tif has an ending that no flow file has; give one ending with \.flo or \.png"),
    ],
)
def test_broken_files_are_refused(tmp_path: Path, name: str, data: bytes, sentence: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=sentence) as error:
        read_flow(tmp_path / name)
    assert "\n" not in str(error.value)


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"b\.flo does not exist; check the name"):
        read_flow(tmp_path / "b.flo")
    (tmp_path / "c.flo").mkdir()
    with pytest.raises(InputError, match=r"c\.flo is a folder; name a flow file"):
        read_flow(tmp_path / "c.flo")


@pytest.mark.parametrize(("suffix", "frames"), [(".flo", 0), (".png", 0), (".npz", 3)])
def test_a_flow_of_which_nothing_is_known_is_refused(tmp_path: Path, suffix: str, frames: int) -> None:
    flow, known = steady(), torch.zeros(SHAPE, dtype=torch.bool)
    if frames:  # one of which is not known
        flow, known = flow.expand(frames, *flow.shape), torch.ones(frames, *SHAPE, dtype=torch.bool)
        known[1] = False
    write_flow(tmp_path / f"a{suffix}", flow, known)
    with pytest.raises(InputError, match=r"a\.npz has a frame without" if frames else "holds no vector that is known"):
        read_flow(tmp_path / f"a{suffix}")


def test_what_a_format_cannot_hold_is_refused_and_nothing_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    write_flow(path, steady())
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"cannot hold vectors of 512 px and more; end it with \.flo"):
        write_flow(path, torch.full((2, 600, 600), 550.0), overwrite=True)
    with pytest.raises(InputError, match=r"cannot hold a flow in time; end it with \.npy or \.npz"):
        write_flow(path, steady()[None], overwrite=True)
    with pytest.raises(InputError, match=r"exists; name another file or allow it with --overwrite"):
        write_flow(path, steady())
    with pytest.raises(InputError, match=r"vectors that are NaN or infinite"):
        write_flow(path, torch.full((2, *SHAPE), torch.nan), overwrite=True)
    with pytest.raises(InputError, match=r"flows have shape \(5,\)"):
        write_flow(path, torch.zeros(5), overwrite=True)
    with pytest.raises(InputError, match="an ending that no flow file has"):
        write_flow(tmp_path / "a.mp4", steady())
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_is_a_field(tmp_path: Path) -> None:
    flows = torch.randn(3, 2, *SHAPE, generator=torch.Generator().manual_seed(1))
    known = torch.ones(3, *SHAPE, dtype=torch.bool)
    known[:, 3, 3] = False
    write_flow(tmp_path / "wind.npz", flows, known)
    field = field_of(tmp_path / "wind.npz")
    assert torch.equal(field(1.0, SHAPE)[:, 5:], flows[1, :, 5:])
    assert torch.equal(field(1.0, SHAPE)[:, 3, 3], flow.filled(flows[1], known[1])[:, 3, 3])
    faster = field_of(str(tmp_path / "wind.npz"), speed=9.0)
    assert math.isclose(max(float(faster(t, SHAPE).norm(dim=0).max()) for t in range(3)), 9.0, rel_tol=1e-5)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("snik", r"'snik' names no flow; give one of uniform, rotation, .* or a file ending with \.flo, \.png"),
        ("missing.flo", r"missing\.flo does not exist; check the name"),
    ],
)
def test_what_names_neither_a_flow_nor_a_file_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        field_of(text)
