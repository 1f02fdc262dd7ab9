"""The EM loop."""

from kwatra.loop.optimize import optimize

__all__ = ["optimize"]
