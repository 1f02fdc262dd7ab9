"""Fixtures of the tests of flowing textures."""

import pytest


@pytest.fixture
def nothing_hides_seams(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in most textures: blocks are as small as is asked for, and seams lie where colors agree."""
    monkeypatch.setattr("flow.animation.film.film.joints", lambda exemplar: None)
