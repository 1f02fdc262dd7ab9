"""A line on the terminal while work goes on: how far, how fast, how long yet."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from synth.saying import seen

_shown = threading.Event()
"""Set while a bar is on the terminal."""


@contextmanager
def working(command: str) -> Iterator[None]:
    """Says on a terminal that a command works, where it shows no bar: while it loads, reads and writes.

    It says so at once, for nothing else can be said while libraries load.
    """
    if not seen():
        yield
        return
    done, began = threading.Event(), time.monotonic()
    sys.stderr.write(f"\rkwatra {command}: at work")
    sys.stderr.flush()
    speaker = threading.Thread(target=_speak, args=(command, began, done), daemon=True)
    speaker.start()
    try:
        yield
    finally:
        done.set()
        speaker.join()


def _speak(command: str, began: float, done: threading.Event) -> None:
    while not done.wait(1.0):
        if not _shown.is_set():
            sys.stderr.write(f"\r\x1b[Kkwatra {command}: at work for {time.monotonic() - began:.0f} s")
            sys.stderr.flush()
    sys.stderr.write("\r\x1b[K")
    sys.stderr.flush()


@contextmanager
def progress_line(title: str) -> Iterator[Callable[[Any], None]]:
    """Gives the callback for `synthesize`; it draws on stderr where that is a terminal and is silent elsewhere."""
    if not seen():
        yield lambda progress: None
        return
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        _telling("{task.fields[place]}, {task.fields[rate]:.1f} iterations/s"),
        TimeRemainingColumn(),
    )
    with _bar(*columns) as bar:
        task = bar.add_task(title, total=1.0, place="level 1", rate=0.0)
        done, furthest = 0, 0.0

        def show(progress: Any) -> None:
            nonlocal done, furthest
            done, furthest = done + 1, max(furthest, progress.fraction)
            elapsed = bar.tasks[task].elapsed or 0.0
            rate = done / elapsed if elapsed else 0.0
            bar.update(task, completed=furthest, place=place_of(progress), rate=rate)

        yield show


def place_of(progress: Any) -> str:
    """Where a run stands, in words: the try where there are several, and the level."""
    level = f"level {progress.level + 1}"
    return level if progress.tries == 1 else f"try {progress.attempt} of {progress.tries}, {level}"


@contextmanager
def work_line(title: str) -> Iterator[Callable[[str, float], None]]:
    """Gives a callback for (what is being done, part done 0..1), drawn on stderr where that is a terminal."""
    if not seen():
        yield lambda what, part: None
        return
    from rich.progress import Progress

    _, *rest = Progress.get_default_columns()
    with _bar(_telling("{task.description}"), *rest) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda what, part: bar.update(task, description=f"{title}: {what}", completed=part)


def _telling(text: str) -> Any:
    """A column with a text of the task, in whose place it says why nothing goes on while loops are compiled."""
    from rich.progress import Task, TextColumn
    from rich.text import Text

    from kwatra.base.compiled import compiling

    class Telling(TextColumn):
        def render(self, task: Task) -> Text:
            return Text("compiling loops, only this once") if compiling() else super().render(task)

    return Telling(text)


@contextmanager
def _bar(*columns: Any) -> Iterator[Any]:
    from rich.console import Console
    from rich.progress import Progress

    _shown.set()
    try:
        sys.stderr.write("\r\x1b[K")
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            yield bar
    finally:
        _shown.clear()
