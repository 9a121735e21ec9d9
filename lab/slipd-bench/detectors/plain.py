"""plain.py NAME: a detector that needs no model of the contact. It gives a score for each frame; the bench sets its threshold.

Each score is of one sensor, relative to P or, where the sensor has no zero, to the readings' size; of several sensors the greatest counts."""
import sys

import numpy as np
from frames import Frames, past_mean, write

FALL_S = 0.5      # P, pattern and shear are compared with their means over this time
STEADY_S = 0.1    # slower than this is no vibration
RMS_S = 0.05


def size_of(frames, values):
    """P, NaN where nothing is held; without a zero the size of the first reading."""
    if not frames.zeroed:
        return np.full(len(values), np.abs(values[0, :, 2]).sum())
    normal = values[:, :, 2].sum(axis=1)
    return np.where(normal > frames.least_normal, normal, np.nan)


def friction(frames, values, _):
    """Q/P: Coulomb's limit with a fixed friction."""
    if not frames.zeroed:
        return np.full(len(values), np.nan)
    return np.linalg.norm(values[:, :, :2].sum(axis=1), axis=1) / size_of(frames, values)


def drop(frames, values, _):
    """How far P fell below its mean."""
    normal = values[:, :, 2].sum(axis=1)
    return (past_mean(normal, frames.rows_in(FALL_S)) - normal) / size_of(frames, values)


def vibration(frames, values, _):
    """Root mean square of fast changes of the shear."""
    shear = values[:, :, :2].sum(axis=1)
    fast = ((shear - past_mean(shear, frames.rows_in(STEADY_S))) ** 2).sum(axis=1)
    return np.sqrt(past_mean(fast, frames.rows_in(RMS_S))) / size_of(frames, values)


def pattern(frames, values, _):
    """Half the sum of the taxels' changes in p/P: the share of the load that other taxels carry now."""
    size = size_of(frames, values)
    share = values[:, :, 2] / size[:, None]
    return 0.5 * np.abs(share - past_mean(np.nan_to_num(share), frames.rows_in(FALL_S))).sum(axis=1)


def rigid(frames, values, taxels_mm):
    """Root mean square of what the shears' changes have beside a common shift and a turn (a contact that sticks moves as a rigid body)."""
    change = values[:, :, :2] - past_mean(values[:, :, :2], frames.rows_in(FALL_S))
    arm = np.array(taxels_mm) - np.mean(taxels_mm, axis=0)
    across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    shift = change.mean(axis=1, keepdims=True)
    turn = (change * across).sum(axis=(1, 2)) / (across ** 2).sum()
    rest = change - shift - turn[:, None, None] * across
    return np.sqrt((rest ** 2).sum(axis=2).mean(axis=1)) * len(arm) / size_of(frames, values)


SCORES = {"friction": friction, "drop": drop, "vibration": vibration, "pattern": pattern, "rigid": rigid}


def greatest(columns):
    """The greatest of several columns in each row, those that are known."""
    stacked = np.stack(columns)
    return np.where(np.isnan(stacked).all(axis=0), np.nan, np.nanmax(np.nan_to_num(stacked, nan=-np.inf), axis=0))


def score(frames, name):
    return greatest([SCORES[name](frames, values, frames.about["sensors"][sensor]["taxels_mm"]) for sensor, values in frames.values.items()])


if __name__ == "__main__":
    frames = Frames(iter(sys.stdin))
    write(frames.times, score(frames, sys.argv[1]))
