import torch

from kwatra import Exemplar, Feature, Level, Prepared, Settings, gradient, optimize

LEVELS = (Level(2, 8, 2), Level(1, 8, 2))


def texture():
    noise = torch.rand(1, 2, 44, 44, generator=torch.Generator().manual_seed(0))
    return Exemplar.of(torch.nn.functional.avg_pool2d(noise, 5, 1)[0])


def test_a_prepared_exemplar_gives_the_same_bits():
    exemplar = texture()
    prepared = Prepared(exemplar)
    for shape, seed, start in [((40, 40), 0, None), ((40, 40), 0, None), ((30, 44), 1, None), ((30, 44), 1, 0.5)]:
        options = {"settings": Settings(levels=LEVELS), "seed": seed}
        if start is not None:
            options["start"] = torch.full((2, *shape), start)
        one, other = (optimize(e, shape, **options) for e in (prepared, exemplar))
        assert torch.equal(one.image, other.image)
        assert torch.equal(one.source, other.source)


def test_windows_are_described_once_for_one_state_of_the_generator():
    prepared = Prepared(texture())

    def windows(seed, width=8, features=()):
        generator = torch.Generator().manual_seed(seed)
        return prepared.source((1, 1), (width, width), generator, features), generator.get_state()

    first, state = windows(0)
    again, same = windows(0)
    assert again is first
    assert torch.equal(same, state)
    assert windows(0, 4)[0] is not first
    assert windows(0, 8, (Feature(gradient),))[0] is not first
    assert windows(1)[0] is not first
