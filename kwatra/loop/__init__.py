"""The EM loop."""

from kwatra.loop.beginning import Beginning, begin
from kwatra.loop.laying import FIBROUS, looks
from kwatra.loop.optimize import improve, optimize

__all__ = ["FIBROUS", "Beginning", "begin", "improve", "looks", "optimize"]
