"""The EM loop."""

from kwatra.loop.beginning import Beginning, begin
from kwatra.loop.optimize import improve, optimize

__all__ = ["Beginning", "begin", "improve", "optimize"]
