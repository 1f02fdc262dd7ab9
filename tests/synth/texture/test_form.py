"""Images come back as they were given, of any kind and dtype, in whatever parts that is worked out."""

import numpy as np
import pytest
import torch

from synth.texture.form import Form

RNG = np.random.default_rng(0)
IMAGES = {
    "gray": RNG.integers(0, 200, (9, 7), dtype=np.uint8),
    "color": RNG.integers(3, 60000, (9, 7, 3), dtype=np.uint16),
    "float": RNG.normal(size=(9, 7, 2)),
    "video": RNG.integers(0, 255, (4, 9, 7, 3), dtype=np.uint8),
    "tensor": torch.from_numpy(RNG.random((3, 9, 7))).float(),
    "tensor of a video": torch.from_numpy(RNG.random((3, 4, 9, 7))).float(),
}


@pytest.mark.parametrize("chunk", [1, 40, 1 << 21])
@pytest.mark.parametrize("name", IMAGES)
def test_what_is_normalized_is_restored(name: str, chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("synth.texture.form.CHUNK", chunk)
    image = IMAGES[name]
    form = Form.of([image])
    normalized = form.normalized(image)
    assert (float(normalized.min()), float(normalized.max())) == (0, 1)
    restored = form.restored(normalized)
    assert type(restored) is type(image)
    assert restored.dtype == image.dtype
    assert restored.shape == image.shape
    np.testing.assert_allclose(np.asarray(restored), np.asarray(image), rtol=1e-6, atol=1e-6)
    if isinstance(restored, np.ndarray):
        assert restored.flags.c_contiguous


def test_what_another_form_normalized_is_normalized_by_this_one() -> None:
    image = IMAGES["color"]
    form, other = Form.of([image]), Form.of([image[:4]])
    torch.testing.assert_close(form.converted(other.normalized(image[:4]), other), form.normalized(image[:4]))
    beyond = form.converted(torch.tensor([[[-0.5, 1.5]]]), other)  # no more than the other's own values
    ends = torch.from_numpy(image[:4].astype(float)).aminmax()
    wanted = (torch.stack([*ends]) - form.low) / (form.high - form.low)
    torch.testing.assert_close(beyond[0, 0], wanted.float())
