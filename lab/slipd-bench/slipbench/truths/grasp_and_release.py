"""What was done is known from a recording's name: a gripper closes, holds and opens and nobody pulls, or something is turned or pulled.

Options, each a pattern for names: quiet; moved: {pattern: [begin_s, end_s]} of the motion; pulled: a pull begins at pull_s, ends when the
taxels' shears have fallen to half, and no margin is safe in it. held_share, released_share: the object is held where P is above this share of
its median, and released where P was last above that one. late_s: an alarm so long after the motion's end tells it."""
import re

import numpy as np

from ..recording import Slip, Truth

SPRUNG_BACK = 0.5


def of(recording, _, options):
    name, sensor = recording.name, next(iter(recording.values))
    normal = recording.values[sensor][:, :, 2].sum(axis=1)
    usual = np.median(normal[normal > 0.1 * normal.max()])
    held = np.flatnonzero(normal > options["held_share"] * usual)
    begin = float(recording.times[held[0]])
    if re.search(options["quiet"], name):
        end = float(recording.times[np.flatnonzero(normal > options["released_share"] * usual)[-1]])
        return Truth(quiet=[(0.0, end)], held=[(begin, end)])
    for pattern, (moves_s, rests_s) in options["moved"].items():
        if re.search(pattern, name):
            return Truth(slips=[Slip(moves_s, rests_s + options["late_s"], moves_s)], unsafe=[(moves_s, rests_s)])
    if re.search(options["pulled"], name):
        shear = np.linalg.norm(recording.values[sensor][:, :, :2], axis=2).sum(axis=1)
        pulled = (recording.times > options["pull_s"]) & (shear > SPRUNG_BACK * shear[recording.times >= options["pull_s"]][0])
        return Truth(unsafe=[(float(t), float(t)) for t in recording.times[pulled]])
    return Truth()
