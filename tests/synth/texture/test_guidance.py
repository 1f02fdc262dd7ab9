"""Guidance: texture goes where the output's map is like the exemplar's, together with everything else."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements, places_of
from made import MADE

import kwatra
from kwatra import HardPixels, InputError, SoftPixels
from synth import synthesize


def lying_and_upright(size: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Lying stripes left and upright ones right, and the map that tells them apart."""
    stripes = np.tile(np.where(np.arange(size) % 8 < 4, 200, 40).astype(np.uint8), (size, 1))
    labels = np.repeat(np.array([[0, 255]], np.uint8), size, 0).repeat(size, 1)
    return np.concatenate([stripes.T, stripes], 1), labels


def wanted(size: int = 80) -> np.ndarray:
    y, x = np.mgrid[:size, :size]
    return np.where((y - 40) ** 2 + (x - 40) ** 2 < 26**2, 255, 0).astype(np.uint8)


def test_texture_by_numbers() -> None:
    image, labels = lying_and_upright()
    made = synthesize(image, guide=(labels, wanted()), preset="fast")
    assert made.image.shape == (80, 80)
    assert made.result.image.shape == (1, 80, 80)
    assert all(stage.shape[0] in (20, 40, 80) for stage in made.stages)
    assert np.mean(made.take(labels) != wanted()) < 0.06
    inside = made.image[28:52, 28:52].astype(float)
    assert np.abs(np.diff(inside, axis=1)).mean() > 4 * np.abs(np.diff(inside, axis=0)).mean()


def test_a_guide_goes_together_with_terms_mask_and_start() -> None:
    image, labels = lying_and_upright()
    here = torch.zeros(1, 80, 80, dtype=torch.bool)
    here[0, :6, :6] = True
    mask = np.ones((80, 80), bool)
    mask[60:, 60:] = False
    start = np.full((80, 80), 77, np.uint8)
    hard, soft = HardPixels(torch.full((1, 80, 80), 0.25), here), SoftPixels(torch.ones(1, 80, 80), 0.01 * here)
    made = synthesize(
        image, guide=([labels], wanted()), terms=hard + soft, mask=mask, start=start, preset="fast", guide_weight=1.0
    )
    assert torch.equal(made.result.image[here], hard.target[here])
    assert bool((made.image[60:, 60:] == 77).all())
    assert bool((made.source[0][~mask] == -1).all())
    assert not made.take(labels)[~mask].any()
    assert {"hard pixels", "soft pixels", "guide"} <= made.result.energies[-1].keys()
    assert np.mean((made.take(labels) != wanted())[mask]) < 0.1


def test_bad_guides_are_refused() -> None:
    image, labels = lying_and_upright()
    for options, message in [
        ({"guide": (labels[:60], wanted())}, "a guide's map is 128x60 but its exemplar 128x64"),
        ({"guide": ([labels, labels], wanted())}, "the guide has 2 maps for 1 exemplars"),
        ({"guide": (labels, wanted()), "guide_weight": 0.0}, "the guide's weight is 0.0"),
        ({"guide": (labels, wanted()), "size": (80, 90)}, r"the size is \(80, 90\) but the guide's output map"),
        ({"guide": (labels, wanted()), "size": 80}, r"width\) is \(80,\); give 2 whole"),
        ({"guide": (labels, wanted()[..., None])}, "the guide's maps differ in their number of axes"),
        ({"guide": (labels[..., None], np.stack([wanted()] * 3, -1))}, "the guide's maps have 1 and 3 channels"),
        ({"guide": (labels,)}, "the guide has 1 parts"),
        ({"guide": [(labels, wanted()), wanted()]}, "the guide has 2 maps for 1 exemplars"),
        ({}, "no size was given"),
    ]:
        with pytest.raises(InputError, match=message):
            synthesize(image, **options)


def test_a_term_that_charges_candidates_charges_them_beside_a_guide_too():
    seen = []

    class Watcher(kwatra.Term):
        name = "watcher"

        def at(self, factor, shape):
            return self

        def quadratic(self, x):
            return kwatra.Quadratic(torch.zeros_like(x[:1]), torch.zeros_like(x))

        def charge(self, x, step):
            def price(corners, windows):
                seen.append((len(x), windows.shape[-1]))
                return windows.flatten(1).mean(1)

            return price

    image = np.random.default_rng(0).random((40, 40, 3)).astype(np.float32)
    labels = (np.indices((40, 40))[1] > 20).astype(np.float32)
    synthesize(image, guide=(labels, labels), terms=Watcher(), levels=[(1, 8)])
    assert seen
    assert set(seen) == {(3, 3)}


def test_several_guides_have_weights_of_their_own() -> None:
    image, labels = lying_and_upright()
    other = np.full(labels.shape, 9, np.uint8)
    other[:, :3] = 0
    against = (255 - wanted()).astype(np.uint8)
    alone = synthesize(
        image, guide=[(labels, wanted()), (other, np.full((80, 80), 9, np.uint8))], preset="fast", seed=1
    )
    assert np.mean(alone.take(labels) != wanted()) < 0.06
    assert np.mean(alone.take(other) == 9) > 0.97
    for weights, followed in (([4.0, 0.01], wanted()), ([0.01, 4.0], against)):
        made = synthesize(image, guide=[(labels, wanted()), (labels, against)], guide_weight=weights, preset="fast")
        assert np.mean(made.take(labels) != followed) < 0.06
    with pytest.raises(InputError, match="there are 2 guides but 3 weights"):
        synthesize(image, guide=[(labels, wanted())] * 2, guide_weight=[1, 1, 1])
    with pytest.raises(InputError, match="the guides' output maps are 80x80 and 70x80"):
        synthesize(image, guide=[(labels, wanted()), (labels, wanted()[:, :70])])


def test_elements_stay_whole_where_a_gradient_is_followed() -> None:
    """Of small blocks alone, and of all levels, three in four of these tiles were cut."""
    tiles, size = MADE["tiles"](128, 20, 0), 200
    y, x = np.mgrid[-1 : 1 : size * 1j, -1 : 1 : size * 1j]
    own, wanted_there = np.tile(np.linspace(0, 1, 128), (128, 1)), np.hypot(x, y) / 1.4
    image = tiles.image.permute(1, 2, 0).numpy()
    made = synthesize(image, guide=(own, wanted_there), guide_weight=0.3)
    assert cut_elements(tiles.numbers.numpy(), made.take(places_of(tiles.image)))["cut"] < 0.4
    assert np.abs(made.take(own) - wanted_there).mean() < 0.08
