"""Files are written whole or not at all."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from kwatra import InputError
from synth.io.outputs import TEMPORARY, Writer, staged, write_files


def text(content: str) -> Writer:
    return lambda path: path.write_text(content) and None


def folder(content: str) -> Writer:
    def write(path: Path) -> None:
        path.mkdir()
        (path / "page").write_text(content)

    return write


def test_several_files_are_written_all_or_none(tmp_path: Path) -> None:
    def broken(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_files({tmp_path / "a.txt": text("whole"), tmp_path / "b.txt": broken}, overwrite=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("error", [OSError("no"), KeyboardInterrupt()])
@pytest.mark.parametrize("failing", [1, 2, 3, 4])
@pytest.mark.parametrize("links", [True, False])
def test_a_move_that_fails_leaves_all_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, failing: int, links: bool
) -> None:
    (tmp_path / "a.txt").write_text("old a")
    folder("old b")(tmp_path / "b")
    new = {tmp_path / name: text("new") for name in ("0", "a.txt", "c")}
    moved, calls = os.replace, 0

    def replace(source: Path, target: Path) -> None:
        nonlocal calls
        calls += 1
        if calls == failing:
            raise error
        moved(source, target)

    def link(*_: object) -> None:
        raise OSError("no links here")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", replace)
        if not links:
            patch.setattr(os, "link", link)
        with pytest.raises(KeyboardInterrupt if isinstance(error, KeyboardInterrupt) else InputError):
            write_files({**new, tmp_path / "b": folder("new")}, overwrite=True)
    assert (tmp_path / "a.txt").read_text() == "old a"
    assert (tmp_path / "b" / "page").read_text() == "old b"
    assert sorted(os.listdir(tmp_path)) == ["a.txt", "b"]


def test_what_was_there_is_replaced_without_a_trace(tmp_path: Path) -> None:
    for content in ("old", "new"):
        write_files(
            {tmp_path / "a.txt": text(content), tmp_path / "b": folder(content), tmp_path / "c": text(content)}, True
        )
    found = [(tmp_path / name).read_text() for name in ("a.txt", "b/page", "c")]
    assert (found, sorted(os.listdir(tmp_path))) == (["new"] * 3, ["a.txt", "b", "c"])


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("kind", [text, folder])
def test_what_came_to_be_meanwhile_is_replaced_only_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: Callable[[str], Writer], links: bool
) -> None:
    def link(*_: object) -> None:
        raise OSError("no links here")

    if not links:
        monkeypatch.setattr(os, "link", link)
    files = {tmp_path / "first": kind("later"), tmp_path / "it": kind("later")}
    with staged(files, overwrite=False) as put:
        write_files({tmp_path / "it": kind("earlier")}, overwrite=False)
        with pytest.raises(InputError, match=r"it came to be while this ran; what was made is .*first-2 and .*it-2$"):
            put()
    place, kept = (tmp_path / name / "page" if kind is folder else tmp_path / name for name in ("it", "it-2"))
    assert (place.read_text(), kept.read_text()) == ("earlier", "later")
    assert sorted(os.listdir(tmp_path)) == ["first-2", "it", "it-2"]
    write_files(files, overwrite=True)
    assert (place.read_text(), sorted(os.listdir(tmp_path))) == ("later", ["first", "first-2", "it", "it-2"])


def test_what_is_kept_beside_takes_the_first_number_that_is_free_for_all(tmp_path: Path) -> None:
    (tmp_path / "a-2.png").write_text("other")
    with staged({tmp_path / "a.png": text("a"), tmp_path / "b.png": text("b")}, overwrite=False) as put:
        (tmp_path / "b.png").write_text("earlier")
        with pytest.raises(InputError, match=r"b\.png came to be .*a-3\.png and .*b-3\.png$"):
            put()
    found = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert found == {"a-2.png": "other", "a-3.png": "a", "b.png": "earlier", "b-3.png": "b"}


def test_temporary_names_are_of_one_call_alone(tmp_path: Path) -> None:
    seen: list[str] = []

    def nested(path: Path) -> None:
        seen.append(path.name)
        if len(seen) < 3:
            write_files({tmp_path / "a.txt": nested}, overwrite=True)
        path.write_text("whole")

    write_files({tmp_path / "a.txt": nested}, overwrite=True)
    assert len(set(seen)) == 3
    assert all(TEMPORARY.fullmatch(name) for name in seen)


def test_a_long_name_is_no_obstacle(tmp_path: Path) -> None:
    path = tmp_path / ("x" * 251 + ".txt")
    write_files({path: text("whole")}, overwrite=False)
    assert path.read_text() == "whole"


def test_staged_files_that_are_not_put_leave_nothing(tmp_path: Path) -> None:
    with staged({tmp_path / "a.txt": text("whole")}, overwrite=False):
        assert len(list(tmp_path.iterdir())) == 1
    assert not list(tmp_path.iterdir())
