"""Elements made up of several copies come in one color, that of what is known of them."""

import numpy as np
import torch
from discs import discs
from torch import Tensor

from kwatra import Exemplar
from kwatra.pieces import Parts, hidden_seams, parts_of
from synth.texture.evening import evened


def case(noise: float = 0.0) -> tuple[Tensor, np.ndarray, Parts, Tensor, Tensor]:
    """Discs, and beside them the same in other colors; their numbers, their parts, where each pixel of the former comes
    from, those from column 70 on from the latter, and where those come from that are known, of the columns before.
    """
    image, number = discs(4, 6, 2, noise)
    image = torch.cat([image, image.flip(0)], 2)  # beside it the same in other colors
    number = np.concatenate([number, number], 1)
    parts = parts_of(hidden_seams(Exemplar.of(image)), np.ones(number.shape, bool))
    where = torch.from_numpy(np.indices((104, 156)))
    copied = where.clone()
    copied[:, :, 70:] = -1
    where[1, :, 70:] += 156
    return image, number[:, :156], parts, where, copied


def test_what_is_copied_takes_the_color_of_what_is_known() -> None:
    image, number, parts, where, copied = case()
    found = evened(image, parts, where, copied, image[:, :, :156])
    assert torch.equal(found[:, :, :70], image[:, :, :70])
    cut = set(np.unique(number[:, 69])) & set(np.unique(number[:, 70])) - {0}
    assert cut
    for one in cut:
        disc = torch.from_numpy(number == one)
        known = image[:, :, :156][:, disc].mean(1)
        other = image[:, :, 156:][:, disc].mean(1)
        assert float((other - known).abs().max()) > 0.1
        away = (found[:, disc] - known[:, None]).abs().amax(0)
        assert float((away < 0.02).float().mean()) > 0.9  # but for some of its rim
        assert float(away.max()) < 0.5 * float((other - known).abs().max())


def test_elements_that_are_not_cut_and_the_ground_stay() -> None:
    image, number, parts, where, copied = case(0.01)
    found = evened(image, parts, where, copied, image[:, :, :156])
    plain = image[(slice(None), *where)]
    cut = set(np.unique(number[:, 66:74]))
    apart = torch.from_numpy(~np.isin(number, [*cut, 0]))
    apart[:, :76] = False  # steps at the border fade there
    assert float((found - plain)[:, apart].abs().max()) < 1e-3
    ground = torch.from_numpy(number == 0)
    away = (found - plain)[:, ground].abs().amax(0)
    assert float((away < 0.05).float().mean()) > 0.99
    assert float(away.max()) < 0.3  # beside a disc, in its shade


def test_colors_stay_within_those_of_the_exemplar() -> None:
    image, _, parts, where, copied = case(0.05)
    found = evened(image, parts, where, copied, image[:, :, :156])
    assert float(found.min()) >= float(image.min())
    assert float(found.max()) <= float(image.max())
