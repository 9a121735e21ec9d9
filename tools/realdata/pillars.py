"""Recordings of 3 x 3 pillars in newtons: grasps that nobody pulls at, an object that is turned, a cable that is pulled."""
import math
from dataclasses import dataclass, field

from . import recordings as rec
from . import rivals

SCENE = "pillars-3x3.json"
RATE_HZ = 500
LEAST_N = 0.5           # of P: below it there is no grasp for the plain detectors
HELD_SHARE = 0.3        # of the median P: above it the object is held
RELEASED_SHARE = 0.9    # the release begins where P was last above this share of the median
TURN_S = (1.0, 1.5)     # when the object is turned
TURN_DELAY_S = 0.3
PULL_BEGINS_S = 1.0
PULLED_SHARE = 0.5      # pulled while the pillars' shears sum to more than this share of what they did when the pull began
SAFE_MARGIN = 0.4       # no margin above this while the cable is pulled
SHEAR_N = 0.5           # more shear than this is contact
FRICTION = 0.38         # that the objects of these grasps have, for the plain detector


@dataclass
class Result:
    quiet: int = 0
    false: dict = field(default_factory=dict)       # detector: quiet grasps with an alarm
    closing: dict = field(default_factory=dict)     # of these, with an alarm before the hold
    held: int = 0                                   # rows of holds
    with_margin: int = 0                            # of these, with a margin
    statistics: dict = field(default_factory=dict)  # plain detector: largest value of each quiet grasp
    turned: dict = field(default_factory=dict)      # detector: delay of the alarm of the turned object, s, None: none
    lost_contact: int = 0                           # rows of the pulled cables in no_contact with shear
    safe: int = 0                                   # rows of them with a margin that is too high
    safe_until_s: float = 0                         # the last of them, after the pull began
    safe_load: float = 0                            # the greatest Q/P of them
    cables: int = 0


LIMITS = {"Q/P over a given friction": FRICTION, "P drops": 0.1, "vibration": 0.02}


def count(table, name, yes):
    table[name] = table.get(name, 0) + (1 if yes else 0)


def of_quiet(result, rows, recording, values):
    loads = sorted(rec.number(r["normal_n"]) or 0 for r in rows)
    usual = loads[len(loads) // 2]
    hold = [i for i, r in enumerate(rows) if (rec.number(r["normal_n"]) or 0) > HELD_SHARE * usual and usual > 0]
    begin = hold[0] if hold else 0
    end = max((i for i, r in enumerate(rows) if (rec.number(r["normal_n"]) or 0) > RELEASED_SHARE * usual), default=len(rows) - 1)
    middle = hold[len(hold) // 4:3 * len(hold) // 4]
    result.quiet += 1
    result.held += len(middle)
    result.with_margin += sum(rows[i]["state"] == "ok" for i in middle)
    alarms = {"slipd": [i for i in range(end + 1) if rec.slips(rows[i])]}
    for name, statistic in values.items():
        alarms[name] = [i for i in range(end + 1) if statistic[i] > LIMITS[name]]
        result.statistics.setdefault(name, []).append(max(statistic[begin:end + 1], default=0.0))
    held_from = middle[0] if middle else end
    for name, found in alarms.items():
        count(result.false, name, bool(found))
        count(result.closing, name, bool(found) and found[0] < held_from)
    return alarms["slipd"]


def of_turned(result, rows, recording, values):
    """Alarms that begin after the turn does; one that stands before says nothing of it."""
    begin = TURN_S[0]
    alarms = {"slipd": [rec.slips(r) for r in rows]}
    alarms.update({name: [v > LIMITS[name] for v in statistic] for name, statistic in values.items()})
    for name, on in alarms.items():
        rises = [recording.times[i] for i in range(1, len(on)) if on[i] and not on[i - 1]]
        result.turned[name] = next((t - begin for t in rises if t >= begin), None)


def pulled(recording):
    """For each row, whether the cable is pulled: it ends when the cable comes off and the pillars spring back."""
    sums = [sum(math.hypot(x, y) for x, y in zip(xs, ys)) for xs, ys in zip(recording.x, recording.y)]
    least = PULLED_SHARE * sums[next(i for i, t in enumerate(recording.times) if t >= PULL_BEGINS_S)]
    return [t > PULL_BEGINS_S and total > least for t, total in zip(recording.times, sums)]


def of_cable(result, rows, recording):
    result.cables += 1
    result.lost_contact += sum(r["state"] == "no_contact" and (rec.number(r["shear_n"]) or 0) > SHEAR_N for r in rows)
    for row, on in zip(rows, pulled(recording)):
        if not (on and row["state"] == "ok" and float(row["gamma"]) > SAFE_MARGIN):
            continue
        result.safe += 1
        result.safe_until_s = max(result.safe_until_s, float(row["time_s"]) - PULL_BEGINS_S)
        result.safe_load = max(result.safe_load, float(row["shear_n"]) / float(row["normal_n"]))


def measure(sliplab, folder):
    result = Result()
    for file in sorted(folder.glob("*.csv")):
        rows = rec.replayed(sliplab, SCENE, file)
        recording = rec.read(file, RATE_HZ)
        values = {name: of(recording, LEAST_N) for name, of in rivals.RIVALS.items()}
        if file.name.startswith("grasp_release"):
            cried = of_quiet(result, rows, recording, values)
            if cried:
                print(f"  {file.name}: slip at {rows[cried[0]]['time_s']} s, {rows[cried[0]]['alert_cause']}")
        elif "moment" in file.name:
            of_turned(result, rows, recording, values)
        elif "cable" in file.name:
            of_cable(result, rows, recording)
    print(f"pillars, quiet grasps: slip raised in {result.false['slipd']} of {result.quiet}; margin in "
          f"{100 * result.with_margin / max(1, result.held):.0f} % of held rows; turned: {result.turned}; cables: no_contact with shear "
          f"{result.lost_contact} rows, safe margin {result.safe} rows")
    return result
