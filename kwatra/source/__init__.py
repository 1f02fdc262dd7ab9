"""What is searched: windows of an exemplar or made-up ones, and where an output comes from."""

from kwatra.source.bag import Bag, Bags
from kwatra.source.canvas import SourceWindows
from kwatra.source.heaviest import heaviest_covering
from kwatra.source.prepared import Prepared, Texture
from kwatra.source.protocol import CHUNK, ROUTES, Description, Placed, Source, chunk
from kwatra.source.sourcemap import at_windows, look_up
from kwatra.source.warped import read_warped

__all__ = [
    "CHUNK",
    "ROUTES",
    "Bag",
    "Bags",
    "Description",
    "Placed",
    "Prepared",
    "Source",
    "SourceWindows",
    "Texture",
    "at_windows",
    "chunk",
    "heaviest_covering",
    "look_up",
    "read_warped",
]
