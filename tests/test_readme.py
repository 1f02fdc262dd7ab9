"""What the README and the pages it leads to show is run as it stands there."""

import re
from pathlib import Path

import numpy as np
import pytest
import torch

ROOT = Path(__file__).parent.parent
NAMES = ("engine", "motion", "motion_measured", "metamorphoses", "commands", "structure", "comparison")
PAGES = {
    page: page.read_text(encoding="utf-8") for page in (ROOT / "README.md", *(ROOT / f"docs/{n}.md" for n in NAMES))
}
README = PAGES[ROOT / "README.md"]
BLOCKS = re.findall(r"```python\n(.*?)```", "\n".join(PAGES.values()), re.DOTALL)


def test_the_python_lines_make_a_picture_and_move_a_map(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(BLOCKS[0], names)
    assert names["made"].image.shape == (384, 500)
    assert names["made"].image.dtype == np.uint8
    assert names["moved"].shape == (384, 500)
    assert (tmp_path / "gravel_synth.png").is_file()


def test_the_term_of_ones_own_shades_the_picture():
    names: dict = {}
    with torch.random.fork_rng():
        torch.manual_seed(0)
        exec(BLOCKS[1], names)
    x = names["result"].image
    assert float(x[..., :32].mean()) > float(x[..., -32:].mean()) + 0.1
    assert names["result"].energies[-1]["shade"] > 0


def test_the_term_of_ones_own_that_charges_makes_the_picture_vary():
    names: dict = {}
    exec("import torch\nimport kwatra\n" + BLOCKS[2], names)

    def variation(x):
        return float(x.unfold(1, 8, 8).unfold(2, 8, 8).flatten(3).var(3).mean())

    assert variation(names["busy"].image) > 1.4 * variation(names["grass"].canvas)


def test_a_part_of_what_is_begun_with_is_laid_anew():
    names: dict = {}
    with torch.random.fork_rng():
        torch.manual_seed(0)
        exec(BLOCKS[3], names)
    changed = (names["other"].copied()[1] != names["where"]).any(0)
    assert names["image"].shape == (3, 96, 96)
    assert bool(changed[40:72, 8:40].any())
    assert names["result"].image.shape == (3, 96, 96)


def test_the_flow_around_the_stone_is_the_one_that_is_seen():
    names: dict = {}
    exec(BLOCKS[6], names)
    assert names["moved"].shape == (1, 240, 320)
    assert names["error"] < 0.25
    assert names["drawn"].shape == (3, 240, 320)
    assert float(names["forward"][:, ~names["stone"]].abs().max()) == 0


def test_known_pixels_and_a_mask_are_kept():
    names: dict = {}
    with torch.random.fork_rng():
        torch.manual_seed(0)
        exec(BLOCKS[4], names)
    image, frame, mask = names["result"].image, names["frame"], names["mask"]
    assert torch.equal(image[frame], names["values"][frame])
    assert not bool(image[:, ~mask].any())


def test_a_hole_is_filled_and_a_guide_followed():
    names: dict = {}
    exec(BLOCKS[5], names)
    hole, gravel, filled = names["hole"], names["gravel"], names["filled"]
    assert np.array_equal(filled.image[~hole], gravel[~hole])
    assert names["made"].image.shape == (160, 200)
    wrong = names["made"].source[0] != names["wanted"] // 255
    assert not wrong[:, np.r_[:45, 80:120, 155:200]].any()
    assert wrong.mean() < 0.06  # bricks at the border are whole


def test_the_gravel_flows_goes_on_and_loops():
    names: dict = {}
    exec(BLOCKS[7], names)
    assert names["shown"].shape == (1, 72, 96)
    assert not names["shown"][:, ~names["stone"]].any()
    assert [frame.state.number for frame in names["more"]] == [4, 5]
    assert len(names["again"]) == 8


def test_what_lies_between_bricks_gravel_and_grass():
    names: dict = {}
    exec(BLOCKS[8], names)
    film, brick = names["film"].frames, names["brick"]
    assert len(film) == 5
    assert np.array_equal(film[0], brick)
    assert names["strip"].shape == (40, 80)
    assert names["strip"].dtype == np.uint8
    assert names["third"].shape == (64, 64)
    expected = (brick.mean() + names["gravel"].mean() + 2 * names["grass"].mean()) / 4
    assert abs(names["third"].mean() - expected) < 8


def test_gravel_turns_into_grass():
    names: dict = {}
    exec(BLOCKS[9], names)
    made, gravel, grass = (names[name] for name in ("made", "gravel", "grass"))
    assert np.array_equal(made.frames[0], gravel)
    assert np.array_equal(made.frames[4], grass)
    assert names["half"].dtype == np.uint8
    assert names["way"].shape == (8, 2, 64, 64)
    result, mask, target = (names[name] for name in ("result", "mask", "target"))
    assert not result.image[:, ~mask].any()
    assert float((result.image - target.target)[:, mask].abs().mean()) < 0.1


def test_every_page_is_reached_and_every_picture_there():
    reached = {ROOT / "README.md"}
    for page, text in PAGES.items():
        links = {(page.parent / link).resolve() for link in re.findall(r"\]\((?!https?:)(.*?)\)", text)}
        assert all(link.is_file() for link in links), page
        reached |= links
    assert {*PAGES, *(ROOT / "docs").iterdir()} <= reached


@pytest.mark.parametrize("command", ["make demo", "make test"])
def test_the_two_commands_come_first(command):
    assert README.index(command) < README.index("## Python")
