"""A folder of frames that Ctrl-C leaves with those that are whole, for both kinds of `kwatra morph`."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.io import Writer


class Folder:
    """A folder of frames, of which an interrupt leaves those that are whole."""

    def __init__(self, path: Path, total: int) -> None:
        self.path, self.total = path, total
        self._left: int | None = None

    def keeping(self, writer: "Writer") -> "Writer":
        """The writer of the folder, which ends at an interrupt as if it were done."""

        def write(target: Path) -> None:
            try:
                writer(target)
            except KeyboardInterrupt:
                self._left = len(list(target.iterdir())) if target.is_dir() else 0
                if not self._left:
                    raise

        return write

    def tell(self) -> None:
        """KeyboardInterrupt, with what is left, if the folder was interrupted."""
        if self._left is not None:
            raise KeyboardInterrupt(f"interrupted with {self._left} of {self.total} frames whole in {self.path}")
