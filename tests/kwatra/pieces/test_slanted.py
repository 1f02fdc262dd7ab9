import pytest
import torch

from kwatra import Exemplar, begin
from kwatra.elements import Slant, easier
from kwatra.loop import laying
from kwatra.pieces import BlockStart, Box, SlantedStart
from kwatra.pieces.slanted import Upright

SLANTS = [Slant(0, 1, 2, 9.0), Slant(0, -2, 3, 9.0), Slant(1, 1, 1, 9.0), Slant(1, -3, 4, 9.0)]


def lines(slant, shape, seed=0):
    """Lines (1, *shape) of random tones, each drawn on the grid as a slant goes."""
    on, aside = shape[slant.along], shape[1 - slant.along]
    tones = torch.rand(on + aside + on, generator=torch.Generator().manual_seed(seed))
    number = torch.arange(aside) - slant.moved(on)[:, None] + on
    return tones[number.movedim(0, slant.along)][None]


@pytest.mark.parametrize("slant", SLANTS)
def test_lines_are_upright(slant):
    image = lines(slant, (40, 56))
    exemplar = Exemplar.of(image)
    upright = Upright(slant, exemplar.shape, 4)
    made = upright.exemplar(exemplar)
    assert upright.room % 4 == 0
    assert int((made.owner == 0).sum()) == 40 * 56  # all pixels are there, once
    assert len(torch.unique(made.origin[1:, made.owner == 0], dim=1)[0]) == 40 * 56
    for line, owned in zip(made.canvas[0].movedim(slant.along, 1), made.owner.movedim(slant.along, 1), strict=True):
        assert len(line[owned == 0].unique()) <= 1  # each is of one tone


@pytest.mark.parametrize("slant", SLANTS)
def test_what_is_laid_upright_is_moved_back(slant):
    """Pixels that are shown in moved rows are shown as far aside, from where they lie in the exemplar."""
    exemplar = Exemplar.of(torch.rand(1, 30, 24))
    upright, shape = Upright(slant, exemplar.shape), (21, 26)
    made = upright.exemplar(exemplar)
    owned = (made.owner == 0).nonzero()
    chosen = owned[torch.randint(len(owned), shape, generator=torch.Generator().manual_seed(0))].movedim(-1, 0)
    back = upright.back(chosen)
    on, aside = shape[slant.along], shape[1 - slant.along]
    moved = slant.moved(on).tolist()
    for row in range(on):
        for column in range(aside):
            there = (row, (column - moved[row]) % aside)
            here, there = ((row, column), there) if slant.along == 0 else ((column, row), there[::-1])
            place = tuple(chosen[(slice(None), *there)].tolist())
            assert back[(slice(None), *here)].tolist() == made.origin[(slice(1, None), *place)].tolist()


@pytest.mark.parametrize("slant", SLANTS)
def test_a_box_is_held_by_that_of_its_moved_pixels(slant):
    shape, box = (32, 40), Box((5, 9), (12, 7))
    upright = Upright(slant, (30, 30))
    size = shape[1 - slant.along]
    held = upright.box(box, size)
    moved = slant.moved(shape[slant.along])
    rows = range(box.start[slant.along], box.stop[slant.along])
    columns = range(box.start[1 - slant.along], box.stop[1 - slant.along])
    at = {int(column - moved[row]) for row in rows for column in columns}
    assert (held.start[1 - slant.along], held.stop[1 - slant.along]) == (min(at), max(at) + 1)
    assert held.start[slant.along] == box.start[slant.along]
    assert held.extent[slant.along] == box.extent[slant.along]
    assert upright.box(box, 8).extent[1 - slant.along] == 8  # all around, and no more


def start(slant, exemplar, grain=(1, 1), kind=SlantedStart):
    block, generator = ((40, 12) if slant.along == 0 else (12, 40)), torch.Generator().manual_seed(1)
    much = 9.0 if slant.along == 0 else 1 / 9
    easy = easier(much, slant.along)
    if kind is BlockStart:
        return BlockStart(exemplar, (72, 96), block, grain, generator, usage=0.5, seams=6, easier=easy)
    return kind(slant, exemplar, (72, 96), block, grain, generator, usage=0.5, seams=6, easier=easy)


@pytest.mark.parametrize("slant", SLANTS)
def test_lines_go_on_in_what_is_laid(slant):
    """Hardly any line ends: where the still's rows were laid as they are many do."""
    exemplar = Exemplar.of(lines(slant, (64, 64)))
    broken = []
    for kind in (SlantedStart, BlockStart):
        where = start(slant, exemplar, kind=kind).run()
        made = exemplar.canvas[0][tuple(where)].movedim(slant.along, 0)
        step = (made[slant.on :].roll(-slant.aside, 1) != made[: -slant.on])[:, 8:-8]
        broken.append(float(step.float().mean()))
    assert broken[0] < 0.5 * broken[1]


@pytest.mark.parametrize("slant", SLANTS)
def test_copies_lie_on_the_grain(slant):
    exemplar = Exemplar.of(torch.rand(3, 64, 64))
    where = start(slant, exemplar, (2, 2)).run()
    offset = torch.stack(torch.meshgrid(torch.arange(72), torch.arange(96), indexing="ij")) - where
    assert (offset % 2 == 0).all()


def test_a_part_is_laid_anew():
    slant = SLANTS[0]
    first = start(slant, Exemplar.of(lines(slant, (64, 64))))
    before = first.run()
    other = first.anew(Box((20, 30), (30, 24)), torch.Generator().manual_seed(9))
    changed = (other.where != before).any(0)
    assert torch.equal(first.where, before)
    assert changed[20:50, 30:54].float().mean() > 0.3
    assert not changed.all()


def test_only_what_is_oblique_and_nothing_steers_is_laid_so(monkeypatch):
    slant, made = SLANTS[0], []
    monkeypatch.setattr(laying, "SlantedStart", lambda *a, **k: made.append(SlantedStart(*a, **k)) or made[-1])
    oblique = lines(slant, (96, 96))
    beginning = begin(Exemplar.of(oblique), (96, 96))
    assert len(made) == 1
    image, where = beginning.anew(Box((10, 10), (40, 40)), 3).copied()
    assert torch.equal(image, oblique[(slice(None), *where)])
    assert torch.equal(beginning.afresh(4).where, begin(Exemplar.of(oblique), (96, 96), seed=4).where)
    draft = begin(Exemplar.of(oblique), (96, 96), draft=True)
    assert draft.blocks.draft
    assert not torch.equal(draft.where, beginning.where)
    assert torch.equal(draft.refined().where, beginning.where)
    made.pop()
    made.pop()
    grain = torch.rand(1, 96, 96, generator=torch.Generator().manual_seed(0))
    for exemplar in (grain, lines(Slant(0, 0, 1, 9.0), (96, 96)), torch.cat([oblique, oblique.flip(-1)], -1)):
        begin(Exemplar.of(exemplar), (96, 96))
    begin(Exemplar.of(oblique, mirror=True), (96, 96))
    begin(Exemplar.of(oblique), (96, 96), mask=torch.ones(96, 96, dtype=torch.bool))
    assert len(made) == 2  # a mask hides, and steers nothing
