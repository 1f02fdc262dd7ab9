"""What users hand over comes in many tensors: those that hold the same values give the same bits, others a sentence."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

import flow
import kwatra
import synth
from kwatra import Exemplar, HardPixels, InputError, SoftPixels, optimize

SHAPE = (24, 24)
IMAGE = torch.rand(3, 32, 32, generator=torch.Generator().manual_seed(0))
WANTED = (IMAGE[:, :24, :24] * 4).round() / 4
HALF = torch.zeros(1, *SHAPE)
HALF[:, :, :12] = 1.0
INSIDE = torch.ones(SHAPE, dtype=torch.bool)
INSIDE[:6, :9] = False
VECTORS = flow.rotation(1.0)(0, SHAPE)

SAME: dict[str, Callable[[Tensor], Any]] = {
    "doubles": lambda t: t.double(),
    "halves": lambda t: t.half(),
    "with derivatives": lambda t: t.clone().requires_grad_(),
    "not contiguous": lambda t: t.transpose(-1, -2).contiguous().transpose(-1, -2),
    "array": lambda t: t.numpy(),
    "flipped array": lambda t: np.ascontiguousarray(t.numpy()[..., ::-1])[..., ::-1],
}
USED: dict[str, Callable[[Any], Tensor]] = {
    "start": lambda t: optimize(Exemplar.of(IMAGE), SHAPE, start=t).image,
    "soft target": lambda t: optimize(Exemplar.of(IMAGE), SHAPE, terms=SoftPixels(t, HALF)).image,
    "hard target": lambda t: optimize(Exemplar.of(IMAGE), SHAPE, terms=HardPixels(t, HALF > 0)).image,
    "first": lambda t: next(flow.animate(IMAGE, flow.rotation(1.0), SHAPE, frames=1, first=t)).image,
}


@pytest.mark.parametrize("tensor", SAME)
@pytest.mark.parametrize("use", USED)
def test_the_same_values_give_the_same_bits(use: str, tensor: str) -> None:
    assert torch.equal(USED[use](SAME[tensor](WANTED)), USED[use](WANTED))


def test_weights_are_booleans_numbers_or_tensors_alike() -> None:
    made = [
        optimize(Exemplar.of(IMAGE), SHAPE, terms=SoftPixels(WANTED, weight)).image
        for weight in (HALF, HALF > 0, HALF.to(torch.uint8), HALF.double())
    ]
    assert all(torch.equal(made[0], other) for other in made[1:])
    listed, given = (Exemplar.of(IMAGE, weights=w) for w in ([1, 2.0, 0.5], torch.tensor([1, 2.0, 0.5])))
    assert torch.equal(listed.weights, given.weights)


def test_a_mask_of_a_flow_may_lie_in_memory_as_it_likes() -> None:
    made = [
        [frame.image for frame in flow.animate(IMAGE, flow.rotation(1.0), SHAPE, frames=2, mask=mask)]
        for mask in (INSIDE, INSIDE.T.contiguous().T)
    ]
    assert all(torch.equal(one, other) for one, other in zip(*made, strict=True))


def test_measures_take_arrays_and_ends_of_flows_derivatives() -> None:
    assert kwatra.measure(WANTED.numpy(), IMAGE.numpy()) == kwatra.measure(WANTED, IMAGE)
    there = VECTORS.clone().requires_grad_()
    assert flow.end_point_error(there, VECTORS, border=2) == 0


def test_sizes_of_frames_between_are_whole_numbers() -> None:
    made = [
        synth.interpolate([IMAGE, IMAGE], [1, 1], size=size, preset="fast").image for size in ((24, 24), (24.0, 24))
    ]
    assert torch.equal(*made)


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "sparse": (lambda: Exemplar.of(IMAGE.to_sparse()), "a tensor is sparse; give it as .to_dense"),
    "seed": (lambda: synth.synthesize(IMAGE, SHAPE, seed=torch.tensor(1.0)), "the seed is 1.0; give a whole"),
    "rotate": (lambda: Exemplar.of(IMAGE, rotate="90"), "an array holds str"),
    "angle": (lambda: Exemplar.of(IMAGE, rotate=torch.tensor(90)), "variants are turned by 90; give several"),
    "terms": (lambda: optimize(Exemplar.of(IMAGE), SHAPE, terms="brick"), "str is not a term"),
    "texture": (lambda: optimize(IMAGE, SHAPE), "the texture is Tensor; give an Exemplar"),
    "mask": (lambda: optimize(Exemplar.of(IMAGE), SHAPE, mask=[[True]]), "a mask is list; give a tensor"),
    "no channels": (lambda: SoftPixels(WANTED[:0], HALF), "soft pixels have targets"),
    "frame sizes": (lambda: synth.interpolate([IMAGE, IMAGE], [1, 1], size=(24.5, 24)), "the size of frames is"),
    "array for a flow": (lambda: flow.lookup(VECTORS.numpy()), "a flow is ndarray; give a tensor"),
    "whole numbers": (lambda: flow.warp((IMAGE * 255).byte(), VECTORS), "an image holds torch.uint8"),
    "bytes": (lambda: flow.seen((IMAGE * 255).byte(), IMAGE), "an image has shape .* and type torch.uint8"),
    "border": (lambda: flow.end_point_error(VECTORS, VECTORS, border=1.5), "the border is 1.5; give a whole"),
    "wheel": (lambda: flow.wheel(1.5), "the wheel's size is"),
    "stretched": (lambda: flow.resampled(VECTORS.long(), (30, 30)), "a flow has shape .* and type torch.int64"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_used_is_told_in_a_sentence(case: str) -> None:
    call, sentence = REFUSED[case]
    with pytest.raises(InputError, match=sentence):
        call()


def test_files_take_no_nan_and_flows_know_by_booleans(tmp_path) -> None:
    kind = synth.Kind("uint8", ("R", "G", "B"))
    with pytest.raises(InputError, match="pixels hold NaN, which uint8 RGB cannot; replace them"):
        synth.write_image(tmp_path / "nan.png", IMAGE * torch.nan, kind)
    with pytest.raises(InputError, match=r"what is known has shape \(24, 24\) and type torch.float32"):
        synth.write_flow(tmp_path / "known.flo", VECTORS, known=HALF[0])
    with pytest.raises(InputError, match=r"flows have shape \(1, 24, 24\)"):
        synth.write_flow(tmp_path / "one.flo", VECTORS[:1])
    synth.write_flow(tmp_path / "learned.flo", VECTORS.clone().requires_grad_())
    assert torch.equal(synth.read_flow(tmp_path / "learned.flo").flow, VECTORS)
    assert [path.name for path in tmp_path.iterdir()] == ["learned.flo"]
