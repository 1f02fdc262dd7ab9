"""What the operating system says of a file that is to be read, in a sentence that names the file."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kwatra.base import InputError


@contextmanager
def reading(path: str | Path, what: str) -> Iterator[None]:
    """Within it a file is read; InputError if it is missing, a folder, or cannot be read. what: to name instead."""
    try:
        yield
    except FileNotFoundError:
        raise InputError(f"{path} does not exist; check the name") from None
    except IsADirectoryError:
        raise InputError(f"{path} is a folder; name {what}") from None
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a name with a NUL is a ValueError
        raise InputError(f"{path} cannot be read ({getattr(error, 'strerror', None) or error}); check it") from error
