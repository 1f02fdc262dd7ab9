"""What an iteration is told of where the optimization stands."""

import torch

from kwatra import Exemplar, Level, Settings, Step, optimize, regular
from kwatra.windows import Layout


def test_layouts_see_the_image_as_it_is() -> None:
    exemplar = Exemplar.of(torch.rand(1, 24, 24, generator=torch.Generator().manual_seed(0)))
    made: list[torch.Tensor] = []
    seen: list[torch.Tensor | None] = []

    def between(image: torch.Tensor, step: Step) -> torch.Tensor:
        made.append(0.9 * image)
        return made[-1]

    def layout(step: Step) -> Layout:
        seen.append(step.image)
        return regular(step)

    settings = Settings(levels=(Level(1, 8, 3),), layout=layout)
    optimize(exemplar, (20, 20), settings=settings, between=between)
    assert seen[0] is None  # where windows lie is asked before there is an image
    assert torch.equal(seen[2], made[0])
    assert torch.equal(seen[3], made[1])


def test_what_is_masked_is_told() -> None:
    exemplar = Exemplar.of(torch.rand(1, 24, 24, generator=torch.Generator().manual_seed(0)))
    mask = torch.ones(20, 20, dtype=torch.bool)
    mask[:, 12:] = False
    seen: dict[int, torch.Tensor | None] = {}

    def between(image: torch.Tensor, step: Step) -> torch.Tensor:
        seen[step.factors[0]] = step.mask
        return image

    settings = Settings(levels=(Level(2, 4, 1), Level(1, 8, 1)))
    optimize(exemplar, (20, 20), settings=settings, between=between, mask=mask)
    assert seen[1] is not None
    assert torch.equal(seen[1], mask)
    assert seen[2] is not None
    assert torch.equal(seen[2], mask[::2, ::2])
    optimize(exemplar, (20, 20), settings=settings, between=between)
    assert seen == {1: None, 2: None}
