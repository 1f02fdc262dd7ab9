import torch

from kwatra import Exemplar
from kwatra.elements import translation


def test_a_translation_is_found_if_it_is_exact():
    sheet = torch.rand(3, 100, 100, generator=torch.Generator().manual_seed(0))

    def panned(down: int, right: int) -> torch.Tensor:
        corners = [(40 - down * t, 40 - right * t) for t in range(4)]
        return torch.stack([sheet[:, y : y + 30, x : x + 28] for y, x in corners], 1)

    for motion in ((3, -2), (0, 5), (-7, 0)):
        clip = panned(*motion)
        assert translation(Exemplar.of(clip)) == motion
        clip[0, 3, 15, 14] += 1 / 255
        assert translation(Exemplar.of(clip)) is None
    assert translation(Exemplar.of(panned(0, 0))) is None
    assert translation(Exemplar.of(panned(1, 1)[:, :1])) is None
    assert translation(Exemplar.of([panned(1, 1), panned(2, 2)])) is None
    assert translation(Exemplar.of(torch.full((3, 4, 30, 28), 0.5))) is None
