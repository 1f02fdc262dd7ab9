import torch

from kwatra import Exemplar, Level, Settings, match_histogram, optimize


def test_the_exemplars_values_are_taken_in_the_images_order():
    generator = torch.Generator().manual_seed(0)
    z = torch.rand(2, 20, 20, generator=generator)
    image = torch.rand(2, 20, 20, generator=generator) * 0.3 + 0.5
    matched = match_histogram(image, Exemplar.of(z))
    for k in range(2):
        assert torch.equal(matched[k].flatten().sort().values, z[k].flatten().sort().values)
        assert torch.equal(matched[k].flatten().argsort(), image[k].flatten().argsort())


def test_masked_pixels_do_not_count():
    z = torch.rand(1, 20, 20, generator=torch.Generator().manual_seed(0))
    mask = torch.ones(20, 20, dtype=torch.bool)
    mask[:5] = False
    z[:, :5] = 5.0
    assert match_histogram(z, Exemplar.of([z], masks=[mask])).max() <= 1


def test_pixels_behind_the_outputs_mask_take_no_rank():
    generator = torch.Generator().manual_seed(0)
    z, image = torch.rand(2, 20, 20, generator=generator), torch.rand(2, 20, 30, generator=generator) + 1
    mask = torch.ones(20, 30, dtype=torch.bool)
    mask[:, 10:] = False
    for hidden in (0.0, 7.0):
        matched = match_histogram(torch.where(mask, image, hidden), Exemplar.of(z), mask)
        assert torch.equal(matched[:, mask], match_histogram(image[:, :, :10], Exemplar.of(z)).flatten(1))
        assert bool((matched[:, ~mask] == hidden).all())


def test_between_is_applied_after_every_blend():
    z = torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0))
    seen = []

    def between(image, exemplar):
        seen.append(tuple(exemplar.shape))
        return match_histogram(image, exemplar)

    settings = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)), tolerance=0)
    image = optimize(Exemplar.of(z), (32, 32), settings=settings, between=between).image
    assert seen == [(16, 16)] * 2 + [(32, 32)] * 2
    assert torch.equal(image.flatten().sort().values, z.flatten().sort().values)
