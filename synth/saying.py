"""What is said on the terminal, whatever the terminal can show."""

import sys
from typing import TextIO


def say(text: str, stream: TextIO | None) -> None:
    """Print what may hold names that the stream cannot show, or to a stream that is closed."""
    if stream is None or stream.closed:
        return
    encoding = stream.encoding or "utf-8"
    print(text.encode(encoding, "backslashreplace").decode(encoding), file=stream, flush=True)


def seen() -> bool:
    """Whether stderr is there and a terminal."""
    return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()


def note(text: str) -> None:
    """One line on stderr about what works, but might better be asked for in another way."""
    clear = "\r\x1b[K" if seen() else ""  # what says that work goes on
    say(f"{clear}kwatra: note: {' '.join(text.split())}", sys.stderr)
