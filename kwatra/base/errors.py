"""The one error that bad input raises."""


class InputError(ValueError):
    """Something the caller gave cannot be used.

    The message is one sentence: what was given, what it may be, and what to do.
    """
