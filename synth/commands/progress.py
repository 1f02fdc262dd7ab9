"""A line on the terminal while work goes on: how far, how fast, how long yet."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def progress_line(title: str) -> Iterator[Callable[[Any], None]]:
    """Gives the callback for `synthesize`; it draws on stderr where that is a terminal and is silent elsewhere."""
    if not sys.stderr.isatty():
        yield lambda progress: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("level {task.fields[level]}, {task.fields[rate]:.1f} iterations/s"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0, level=1, rate=0.0)
        done = 0

        def show(progress: Any) -> None:
            nonlocal done
            done += 1
            elapsed = bar.tasks[task].elapsed or 0.0
            rate = done / elapsed if elapsed else 0.0
            bar.update(task, completed=progress.fraction, level=progress.level + 1, rate=rate)

        yield show


@contextmanager
def work_line(title: str) -> Iterator[Callable[[str, float], None]]:
    """Gives a callback for (what is being done, part done 0..1), drawn on stderr where that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda what, part: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda what, part: bar.update(task, description=f"{title}: {what}", completed=part)
