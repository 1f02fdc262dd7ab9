from fractions import Fraction

import pytest
import torch

from kwatra import Exemplar, InputError, Level, Settings, match_histogram, optimize
from kwatra.source import Bag, SourceWindows
from kwatra.step import Step
from kwatra.steps.histogram import ranks


def step(exemplar, mask=None):
    generator = torch.Generator().manual_seed(0)
    source = SourceWindows(exemplar, (4, 4), generator)
    return Step(Level(1, 4), 0, 1, (1, 1), (20, 20), (False, False), source, exemplar, mask, generator)


def test_the_exemplars_values_are_taken_in_the_images_order():
    generator = torch.Generator().manual_seed(0)
    z = torch.rand(2, 20, 20, generator=generator)
    image = torch.rand(2, 20, 20, generator=generator) * 0.3 + 0.5
    matched = match_histogram(image, step(Exemplar.of(z)))
    for k in range(2):
        assert torch.equal(matched[k].flatten().sort().values, z[k].flatten().sort().values)
        assert torch.equal(matched[k].flatten().argsort(), image[k].flatten().argsort())


def test_ranks_are_exact_however_many_there_are():
    assert ranks(3, 2**24 + 2).tolist() == [0, 2**23, 2**24 + 1]
    assert ranks(2**18 + 1, 3 * 2**18 + 1).tolist() == list(range(0, 3 * 2**18 + 1, 3))
    for count, of in ((1, 7), (7, 1), (4, 7), (7, 4), (55, 62)):
        exact = [round(Fraction(place * (of - 1), max(count - 1, 1))) for place in range(count)]
        assert ranks(count, of).tolist() == exact


def test_masked_pixels_do_not_count():
    z = torch.rand(1, 20, 20, generator=torch.Generator().manual_seed(0))
    mask = torch.ones(20, 20, dtype=torch.bool)
    mask[:5] = False
    z[:, :5] = 5.0
    assert match_histogram(z, step(Exemplar.of([z], masks=[mask]))).max() <= 1


def test_pixels_behind_the_outputs_mask_stay_and_have_no_rank():
    z = torch.rand(1, 20, 20, generator=torch.Generator().manual_seed(0)) * 0.5 + 0.5
    mask = torch.ones(20, 20, dtype=torch.bool)
    mask[:, :10] = False
    inside = torch.rand(1, 20, 20, generator=torch.Generator().manual_seed(1))
    matched = match_histogram(torch.where(mask, inside, 0.0), step(Exemplar.of(z), mask))
    other = match_histogram(torch.where(mask, inside, 7.0), step(Exemplar.of(z), mask))
    assert torch.equal(matched[:, mask], other[:, mask])
    assert bool((other[:, ~mask] == 7).all())
    wanted = z.flatten().sort().values[torch.linspace(0, 399, 200).round().long()]
    assert torch.equal(matched[:, mask].flatten().sort().values, wanted)


def test_between_is_applied_after_every_blend():
    z = torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0))
    seen = []

    def between(image, step):
        seen.append((step.number, step.iteration, step.exemplar.shape, tuple(step.where.shape)))
        return match_histogram(image, step)

    settings = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)))
    image = optimize(Exemplar.of(z), (32, 32), settings=settings, between=between).image
    assert seen == [(k, i, s, (2, *s)) for k, s in enumerate([(16, 16), (32, 32)]) for i in (1, 2)]
    assert torch.equal(image.flatten().sort().values, z.flatten().sort().values)


def test_without_an_exemplar_there_is_no_histogram():
    generator = torch.Generator().manual_seed(0)
    bag = Bag(torch.rand(9, 4, 4, 1, generator=generator), torch.ones(1), generator)
    nowhere = Step(Level(1, 4), 0, 1, (1, 1), (20, 20), (False, False), bag, None, None, generator)
    with pytest.raises(InputError, match="windows come from none"):
        match_histogram(torch.rand(1, 20, 20), nowhere)


def test_what_between_makes_is_checked_to_the_last():
    exemplar = Exemplar.of(torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0)))
    settings = Settings(levels=(Level(1, 8, 1),))
    with pytest.raises(FloatingPointError, match="`between` made pixels NaN or infinite in iteration 1"):
        optimize(exemplar, (32, 32), settings=settings, between=lambda image, step: image * torch.nan)
