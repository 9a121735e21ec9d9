"""Whether a detector keeps the interface: what it says of the beginning of a recording must not depend on what comes later."""
import copy

import numpy as np

from .detector import decide, frames_of
from .sets import WrongUse


def beginning(recording, rows):
    part = copy.copy(recording)
    part.times, part.values = recording.times[:rows], {name: values[:rows] for name, values in recording.values.items()}
    return part


def same(a, b):
    return a is b is None or np.array_equal(a, b, equal_nan=True)


def check(detector, recording):
    half = beginning(recording, len(recording.times) // 2)
    whole, early = (decide(detector, r, frames_of(r)) for r in (recording, half))
    for what in ("alarm", "score", "gamma"):
        a, b = getattr(whole, what), getattr(early, what)
        if not same(None if a is None else a[:len(half.times)], b):
            raise WrongUse(f"{detector.name}: its {what} of the first half of {recording.name} is another if the second half is missing: "
                           "it looks into the future")
