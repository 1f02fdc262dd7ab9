"""What is searched: the windows of an exemplar, and where an output comes from."""

from kwatra.source.canvas import CHUNK, ROUTES, SourceWindows, cheapest
from kwatra.source.prepared import Prepared
from kwatra.source.sourcemap import at_windows, look_up

__all__ = ["CHUNK", "ROUTES", "Prepared", "SourceWindows", "at_windows", "cheapest", "look_up"]
