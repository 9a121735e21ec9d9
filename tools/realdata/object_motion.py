"""How an object moves in a hand, by a marker that a camera on the hand sees."""
import csv
import math
from dataclasses import dataclass

ARM_M = 0.008         # motion is that of the grip's centre, and of a point so far from it
LOST_M = 5            # a lost marker reads 10
SMOOTH_ROWS = 5       # of the running median: single rows jump by some millimetres
STILL_M = 0.0005      # a second with less motion is still: the marker of an object that sticks moves by so much,
MOVING_M = 0.002      # one with more moves
TURNING_RAD = math.radians(3)
PURE = 0.5            # translation over a turn's motion at most, in seconds of pure turning
# The grip's centre in the camera's frame: what moves least while the objects of all 37 recordings turn (they turn about the camera's x).
CENTRE_M = (0.020, 0.0, 0.222)


@dataclass
class Second:
    begin_s: float
    kind: str         # still, moving, turning (and nothing else), between
    translation_m: float
    turn_rad: float


def angle_between(a, b):
    """Of two quaternions, rad."""
    size = math.sqrt(sum(v * v for v in a) * sum(v * v for v in b))
    return 2 * math.acos(min(1.0, abs(sum(v * w for v, w in zip(a, b))) / size)) if size else math.nan


def read_poses(file):
    """(position, quaternion) of the first marker in each row; None where it is lost or frozen."""
    with open(file, newline="") as lines:
        rows = [[float(v) for v in row[:7]] for row in list(csv.reader(lines))[1:]]
    poses = []
    for i, row in enumerate(rows):
        lost = max(abs(v) for v in row[:3]) > LOST_M or (i > 0 and row == rows[i - 1])
        poses.append(None if lost else (row[:3], row[3:]))
    return poses


def rotated(quaternion, v):
    x, y, z, w = quaternion
    t = (2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0]))
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]]


def between(a, b):
    """How the object moved from pose a to b: translation at the grip's centre, m, and turn, rad."""
    (at_a, q_a), (at_b, q_b) = a, b
    inverse = (-q_a[0], -q_a[1], -q_a[2], q_a[3])
    arm = rotated(q_b, rotated(inverse, [c - p for c, p in zip(CENTRE_M, at_a)]))
    moved = [p + r - c for p, r, c in zip(at_b, arm, CENTRE_M)]
    return math.sqrt(sum(v * v for v in moved)), angle_between(q_a, q_b)


def steady(poses, row):
    """The pose about this row whose place is the median; None: too few rows saw it."""
    near = [p for p in poses[max(0, row - SMOOTH_ROWS // 2):row + SMOOTH_ROWS // 2 + 1] if p is not None]
    if len(near) <= SMOOTH_ROWS // 2:
        return None
    return sorted(near, key=lambda p: p[0][2])[len(near) // 2]


def kind_of(translation_m, turn_rad):
    motion = translation_m + ARM_M * turn_rad
    if motion < STILL_M:
        return "still"
    if turn_rad > TURNING_RAD and translation_m < PURE * ARM_M * turn_rad:
        return "turning"
    return "moving" if motion > MOVING_M else "between"


def seconds_of(file, rate_hz, begin_s, end_s):
    poses = read_poses(file)
    found = []
    second = 0
    while begin_s + second + 1 <= end_s:
        at = begin_s + second
        a, b = (steady(poses, round(t * rate_hz)) for t in (at, at + 1))
        second += 1
        if a is None or b is None:
            continue
        translation, turn = between(a, b)
        found.append(Second(at, kind_of(translation, turn), translation, turn))
    return found
