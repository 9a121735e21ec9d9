"""How the object moves in the hand, by a marker that a camera on the hand sees.

Motion is the translation at the grip's centre, plus ARM_M times the turn, since the hand began to lift. A limit is passed where the motion is
above it and its median over the next HOLD_S, too: single poses jump. `slip`: more than 5 mm or 10 degrees; `still`: at most 2 mm and 3 degrees;
what lies between, counts for nothing.

Seconds from lifting on, by the motion within each: `still` below STILL_SECOND_M, moving above TOLD_M, and `turning` where the turn exceeds
STILL_TURN and the translation is less than half of the turn's motion, `along` where the turn's is less than half of the translation. Sensors lag behind
the camera by LAG_S.

Options: file, hand, lift (column of the hand's height), contact_share (of the greatest P), centre_m, early_s, late_s as in onset_table."""
import numpy as np

from ..readers.csv_rows import read_columns
from ..recording import Truth
from .moved import judged

ARM_M = 0.008
LOST_M = 5           # a lost marker reads 10
SMOOTH_ROWS = 5      # of the running median
HOLD_S = 0.3
REST_S = 0.3         # before lifting: the pose that motion counts from
FREE_S = 0.5         # the hand rests, and nothing touches the sensors
LIFTED_M = 0.001
ONSET_M, TOLD_M, SLIP_M, STILL_M = 0.001, 0.002, 0.005, 0.002
STILL_SECOND_M = 0.0005
PURE = 0.5           # of a second: the other motion is a smaller share of this one
LAG_S = 0.07
TURNED, STILL_TURN = np.radians(10), np.radians(3)


def rotated(q, v):
    t = 2 * np.cross(q[..., :3], v)
    return v + q[..., 3:] * t + np.cross(q[..., :3], t)


def running_median(rows):
    half = SMOOTH_ROWS // 2
    padded = np.pad(rows, ((half, half), (0, 0)), mode="edge")
    return np.ma.median(np.ma.masked_invalid(np.stack([padded[i:i + len(rows)] for i in range(SMOOTH_ROWS)])), axis=0).filled(np.nan)


def poses_of(file):
    """x, y, z, quaternion of the first marker in each row; NaN where it is lost or frozen."""
    rows = read_columns(file)[1][:, :7]
    rows[:, 3:] /= np.maximum(np.linalg.norm(rows[:, 3:], axis=1, keepdims=True), 1e-9)
    rows[:, 3:] *= np.where(rows[:, 3:] @ rows[0, 3:] < 0, -1, 1)[:, None]
    lost = (np.abs(rows[:, :3]).max(axis=1) > LOST_M) | np.r_[False, (rows[1:] == rows[:-1]).all(axis=1)]
    rows[lost] = np.nan
    return running_median(rows)


def motion_since(poses, reference, centre_m):
    """Translation at the grip's centre, m, and turn, rad, of each row."""
    turn_back = reference[3:] / np.linalg.norm(reference[3:]) * [-1, -1, -1, 1]
    now = poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    arm = rotated(now, np.broadcast_to(rotated(turn_back, centre_m - reference[:3]), (len(now), 3)))
    moved = np.linalg.norm(poses[:, :3] + arm - centre_m, axis=1)
    return moved, 2 * np.arccos(np.clip(np.abs(now @ (turn_back * [-1, -1, -1, 1])), 0, 1))


def passed_s(values, limit, times, rate_hz):
    rows = int(HOLD_S * rate_hz) + 1
    for i in np.flatnonzero(values > limit):
        if np.nanmedian(values[i:i + rows]) > limit:
            return float(times[i])
    return None


def kind_of_second(moved_m, turned):
    motion = moved_m + ARM_M * turned
    if motion < STILL_SECOND_M:
        return "still"
    if turned > STILL_TURN and moved_m < PURE * ARM_M * turned:
        return "turning"
    if motion <= TOLD_M:
        return None
    return "along" if ARM_M * turned < PURE * moved_m else "moving"


def seconds_of(poses, rate_hz, begin_s, end_s, centre_m):
    found = []
    for at in np.arange(begin_s, end_s - 1, 1.0):
        a, b = (poses[min(round(t * rate_hz), len(poses) - 1)] for t in (at, at + 1))
        if np.isnan(a).any() or np.isnan(b).any():
            continue
        moved, turned = motion_since(b[None], a, centre_m)
        kind = kind_of_second(moved[0], turned[0])
        if kind:
            found.append((float(at) + LAG_S, kind))
    return found


def of(recording, folder, options):
    of_grasp = folder / recording.name
    names, hand = read_columns(of_grasp / options["hand"])
    height = hand[:, names.index(options["lift"])]
    height = height - np.median(height[:int(FREE_S * recording.rate_hz)])
    pressed = sum(recording.normal(sensor) for sensor in recording.values)
    contact_s = float(recording.times[np.argmax(pressed > options["contact_share"] * pressed.max())])
    count = min(len(height), len(recording.times))
    lifted = np.flatnonzero((height[:count] > LIFTED_M) & (recording.times[:count] > contact_s))
    if not len(lifted):
        return Truth()
    lift_s, poses = float(recording.times[lifted[0]]), poses_of(of_grasp / options["file"])[:count]
    times = recording.times[:len(poses)]
    before = poses[(times >= lift_s - REST_S) & (times <= lift_s)]
    moved, turned = motion_since(poses, np.nanmedian(before, axis=0), np.array(options["centre_m"]))
    held = times >= lift_s
    times, motion, turned = times[held], (moved + ARM_M * turned)[held], turned[held]
    moved_most, turned_most = np.nanmax(motion), np.nanmax(turned)
    kind = ("slip" if moved_most > SLIP_M or turned_most > TURNED else
            "still" if moved_most <= STILL_M and turned_most <= STILL_TURN else "between")
    onset, told = (passed_s(motion, limit, times, recording.rate_hz) for limit in (ONSET_M, TOLD_M))
    truth = judged(kind, contact_s, recording.end_s, onset, [told, passed_s(turned, TURNED, times, recording.rate_hz)], options)
    truth.seconds = seconds_of(poses, recording.rate_hz, lift_s, recording.end_s, np.array(options["centre_m"]))
    return truth
