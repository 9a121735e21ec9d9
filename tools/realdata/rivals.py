"""Plain detectors that need no model of the contact. Each gives a number for each row; it alarms above its threshold.

* friction: Q/P, against a friction that is given (Coulomb; the usual "fixed friction" of grasp controllers).
* drop: how far P fell below its mean of half a second before, share of it.
* vibration: root mean square over 50 ms of the shear's difference from its mean over 100 ms, over P.
* moved: change of all channels since the hold began, root mean square over the noise of the hold (needs no zero).
"""
import math

DROP_S = 0.5        # P is compared with its mean over this time
STEADY_S = 0.1      # slower than this is no vibration
RMS_S = 0.05
HOLD_S = 0.5        # the hold that `moved` compares with


def rows_in(recording, seconds):
    step = (recording.times[-1] - recording.times[0]) / max(1, len(recording.times) - 1)
    return max(1, round(seconds / step))


def moving_mean(values, before, after=0):
    """Mean of values[i - before … i + after], of as many as there are."""
    sums = [0.0]
    for value in values:
        sums.append(sums[-1] + value)
    out = []
    for i in range(len(values)):
        low, high = max(0, i - before), min(len(values), i + after + 1)
        out.append((sums[high] - sums[low]) / (high - low))
    return out


def friction(recording, least_normal):
    return recording.ratio(least_normal)


def drop(recording, least_normal):
    normal = recording.normal()
    means = moving_mean(normal, rows_in(recording, DROP_S))
    return [1 - p / mean if mean > least_normal else 0.0 for p, mean in zip(normal, means)]


def vibration(recording, least_normal):
    normal = recording.normal()
    half, window = rows_in(recording, STEADY_S) // 2, rows_in(recording, RMS_S)
    squares = [0.0] * len(normal)
    for sums in ([sum(row) for row in recording.x], [sum(row) for row in recording.y]):
        for i, (value, mean) in enumerate(zip(sums, moving_mean(sums, half, half))):
            squares[i] += (value - mean) ** 2
    return [math.sqrt(square) / p if p > least_normal else 0.0 for square, p in zip(moving_mean(squares, window), normal)]


def moved(recording, _):
    count = rows_in(recording, HOLD_S)
    channels = [[row[k] for row in axis] for axis in (recording.x, recording.y, recording.z) for k in range(len(axis[0]))]
    squares, noise = [0.0] * len(recording.times), 0.0
    for values in channels:
        mean = sum(values[:count]) / count
        noise += sum((value - mean) ** 2 for value in values[:count]) / count
        for i, value in enumerate(values):
            squares[i] += (value - mean) ** 2
    return [math.sqrt(square / noise) if noise else 0.0 for square in squares]


RIVALS = {"Q/P over a given friction": friction, "P drops": drop, "vibration": vibration}
