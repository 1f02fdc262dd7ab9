"""What holds for all tests."""

import synth  # noqa: F401  # before torch: waiting threads sleep, which a busy machine thanks with twice the speed
