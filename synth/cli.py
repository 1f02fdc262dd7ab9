"""The command line: `kwatra synth`, `fill`, `tile` and the others that `synth.commands` lists.

Bad input ends with one sentence on stderr and exit code 2, Ctrl-C with 130 from the first instruction on. What takes
long to import is imported when a command runs, so that `--help` answers at once.
"""

import atexit
import gc
import os
import re
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from synth.saying import say

if TYPE_CHECKING:
    import argparse

_NOTHING = "interrupted, nothing was written"


def entry() -> NoReturn:
    """Run the command line of this process and end it at once: to take torch apart again would take half a second.

    What is loaded stays, so nobody looks for garbage in it: that took a tenth of loading. The threads of numpy's and
    scipy's linear algebra, of which we ask nothing large, would spin for a tenth of a second each.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.disable()  # until all is loaded
    code = main()
    atexit._run_exitfuncs()  # what libraries, and our own files, want done is done
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, broken, or none
            stream.flush()
    os._exit(code)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code. `argv`: None for this process's own arguments."""
    interrupts = _Interrupts()
    try:
        return _run(argv, interrupts)
    except (KeyboardInterrupt, Exception) as error:
        if isinstance(error, KeyboardInterrupt):
            return _fail(str(error) or _NOTHING, 130)
        if interrupts.came:  # native code that is interrupted while it loads raises what it likes
            return _fail(_NOTHING, 130)
        if isinstance(error, BrokenPipeError):
            # whoever read the output has gone; python must not find that out again when it ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        sentence = _sentence(error)
        if sentence is None:
            raise
        return _fail(sentence, 2)
    finally:
        interrupts.leave(ended=argv is None)


def _run(argv: Sequence[str] | None, interrupts: "_Interrupts") -> int:
    from synth.packages import shadowed

    words = sys.argv[1:] if argv is None else list(argv)
    arguments = _parser(words).parse_args(words)
    stranger = shadowed()
    if stranger is not None:
        return _fail(stranger, 2)
    summary = _performed(arguments, words, interrupts)
    say(summary, sys.stderr if re.match(r"wrote -(?=[:, ])", summary) else sys.stdout)
    return 0


def perform(words: Sequence[str]) -> str:
    """Do what the words of a command line say; returns the summary. Raises what goes wrong."""
    return _performed(_parser(words).parse_args(words), words, None)


def _performed(arguments: "argparse.Namespace", words: Sequence[str], interrupts: "_Interrupts | None") -> str:
    """The summary of a command, whose recipe is saved if that is asked."""
    from importlib import import_module

    command = import_module(f"synth.commands.{arguments.command}")
    with import_module("synth.commands.progress").working(arguments.command):
        for module in command.LOADS:
            import_module(module)
        if interrupts is not None:
            interrupts.loading = False
        if not gc.isenabled():
            gc.freeze()
            gc.enable()
        if getattr(arguments, "save_recipe", None) is None:
            summary: str = command.run(arguments)
            return summary
        recipes = import_module("synth.commands.recipes")
        recipe = recipes.begun(arguments, words)
        summary = command.run(arguments)
        recipes.saved(recipe, arguments.save_recipe, arguments.overwrite)
        return f"{summary}\nits recipe is {arguments.save_recipe}"


class _Interrupts:
    """What Ctrl-C does: while modules load it ends the process at once, for nothing has begun; then it raises."""

    def __init__(self) -> None:
        self.loading, self.came = True, False
        self._before = signal.getsignal(signal.SIGINT)
        self._ours = threading.current_thread() is threading.main_thread() and self._before is not signal.SIG_IGN
        if self._ours:
            signal.signal(signal.SIGINT, self._heed)

    def _heed(self, number: int, frame: FrameType | None) -> None:
        if self.loading:
            say(f"kwatra: {_NOTHING}", sys.stderr)
            os._exit(130)
        self.came = True
        raise KeyboardInterrupt

    def leave(self, ended: bool) -> None:
        """Ctrl-C means again what it did before, or no more where the process ends."""
        if self._ours:
            signal.signal(signal.SIGINT, signal.SIG_IGN if ended else self._before)


def _parser(words: Sequence[str]) -> "argparse.ArgumentParser":
    """The parser of a command line: of the command that it begins with, or else of all."""
    from importlib import import_module

    from synth import commands
    from synth.commands.parsing import Parser, Version

    parser = Parser(prog="kwatra", description="Texture synthesis from examples.")
    parser.add_argument("--version", action=Version, nargs=0, help="print the version and exit")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in [name for name in commands.NAMES if name in words[:1]] or commands.NAMES:
        import_module(f"synth.commands.{name}").add(subparsers)
    return parser


def _sentence(error: Exception) -> str | None:
    """What a person is told about an error; None where it is a fault of our own."""
    if isinstance(error, MemoryError) or "allocate memory" in str(error) or "out of memory" in str(error):
        return "there is not enough memory; ask for a smaller --size"
    if isinstance(error, ImportError) and (error.name or "").partition(".")[0] not in ("kwatra", "flow", "synth"):
        return f"a library could not be loaded ({error}); install kwatra anew, with all that it needs"
    if isinstance(error, OSError):
        return f"{error.filename or 'a file'} cannot be used ({error.strerror or error}); choose another"
    base = sys.modules.get("kwatra.base")
    return str(error) if base is not None and isinstance(error, base.InputError) else None


def _fail(sentence: str, code: int) -> int:
    say(f"kwatra:{' error:' if code == 2 else ''} {' '.join(sentence.split())}", sys.stderr)
    return code


if __name__ == "__main__":
    entry()
