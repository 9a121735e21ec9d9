"""What decisions are worth against the truth. Every figure, table and picture counts these same episodes and rows (docs/slipd-bench.md).

An episode is alarm without a pause of PAUSE_S. It tells a slip in time if it begins in the slip's window; a quiet interval that it touches has a
false alarm. A slip whose window begins in an alarm that never ends in it, is `standing`: nothing told it."""
from dataclasses import dataclass, field

import numpy as np

from .recording import within

PAUSE_S = 0.5
BEFORE_S = 0.5
SAFE_MARGIN = 0.4      # where the default alerts begin to warn
THRESHOLDS = 100
MOST_PER_HOUR = 360    # the area counts up to one false alarm in ten seconds


@dataclass
class Counts:
    """Of one recording. Times in s."""
    block: str
    slips: int = 0
    in_time: int = 0
    late: int = 0
    standing: int = 0
    latencies: list = field(default_factory=list)   # of slips told in time or late, whose onset is known
    quiet: int = 0                                  # 1 where the whole recording is quiet
    quiet_alarmed: int = 0
    false: int = 0
    held_s: float = 0
    alarmed_s: float = 0                            # of held_s
    judged_s: float = 0                             # held, or in a slip's window
    answered_s: float = 0                           # of judged_s
    margin_s: float = 0                             # of held_s, with a margin
    unsafe_s: float = 0
    called_safe_s: float = 0                        # of unsafe_s, with a margin above SAFE_MARGIN
    gamma_errors: list = field(default_factory=list)
    low_before: list = field(default_factory=list)  # gamma_low, its median over BEFORE_S before each onset
    low_held: list = field(default_factory=list)    # its median over a quiet recording's holding
    moving: int = 0                                 # seconds of each kind, and those with an alarm in them
    moving_told: int = 0
    still: int = 0
    still_told: int = 0
    turning: int = 0
    turning_told: int = 0                           # as a rotation
    along: int = 0
    along_told: int = 0                             # as a rotation: wrongly
    curve_in_time: np.ndarray | None = None         # at each threshold
    curve_false: np.ndarray | None = None


def episodes(alarm, times):
    """Pairs (begin, end) in s."""
    edges = np.diff(np.concatenate([[0], alarm.astype(np.int8), [0]]))
    found = []
    for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1):
        if found and times[begin] - found[-1][1] < PAUSE_S:
            found[-1] = (found[-1][0], times[end])
        else:
            found.append((times[begin], times[end]))
    return found


def told(slip, alarms, end_s):
    """in_time, late, standing or missed, and the time of the alarm, s."""
    after = [begin for begin, _ in alarms if begin >= slip.begin_s]
    if after and after[0] <= slip.end_s:
        return "in_time", after[0]
    if any(begin < slip.begin_s <= end for begin, end in alarms):
        return "standing", None
    return ("late", after[0]) if after and after[0] <= end_s else ("missed", None)


def false_in(alarms, quiet):
    return sum(begin <= to and end >= since for since, to in quiet for begin, end in alarms)


def row_seconds(times):
    """The time that each row stands for."""
    return np.append(np.diff(times), np.median(np.diff(times)))


def count(recording, decisions, alarm):
    truth, times, counts = recording.truth, recording.times, Counts(recording.block)
    alarms, seconds = episodes(alarm, times), row_seconds(times)
    counts.slips = len(truth.slips)
    for slip in truth.slips:
        way, at = told(slip, alarms, recording.end_s)
        if way != "missed":
            setattr(counts, way, getattr(counts, way) + 1)
        if at is not None and slip.onset_s is not None:
            counts.latencies.append(at - slip.onset_s)
    counts.false = false_in(alarms, truth.quiet)
    counts.quiet = int(bool(truth.quiet) and not truth.slips)
    counts.quiet_alarmed = int(counts.quiet and counts.false > 0)
    held, unsafe = within(times, truth.held), within(times, truth.unsafe)
    judged = held | within(times, [(s.begin_s, s.end_s) for s in truth.slips])
    with_margin = ~np.isnan(decisions.gamma)
    counts.held_s, counts.alarmed_s = seconds[held].sum(), seconds[held & alarm].sum()
    counts.judged_s, counts.answered_s = seconds[judged].sum(), seconds[judged & decisions.answered].sum()
    counts.margin_s, counts.unsafe_s = seconds[held & with_margin].sum(), seconds[unsafe].sum()
    counts.called_safe_s = seconds[unsafe & (np.nan_to_num(decisions.gamma) > SAFE_MARGIN)].sum()
    if truth.gamma is not None:
        counts.gamma_errors = (decisions.gamma - truth.gamma)[with_margin & ~np.isnan(truth.gamma)].tolist()
    count_bounds(recording, decisions, counts)
    count_seconds(recording, decisions, alarm, counts)
    return counts


def median_of(values):
    known = values[~np.isnan(values)]
    return [float(np.median(known))] if len(known) else []


def count_bounds(recording, decisions, counts):
    times, truth = recording.times, recording.truth
    for slip in truth.slips:
        if slip.onset_s is not None:
            counts.low_before += median_of(decisions.low[(times >= slip.onset_s - BEFORE_S) & (times <= slip.onset_s)])
    if counts.quiet:
        counts.low_held += median_of(decisions.low[within(times, truth.held)])


def count_seconds(recording, decisions, alarm, counts):
    for begin, kind in recording.truth.seconds:
        rows = (recording.times >= begin) & (recording.times <= begin + 1)
        told = int(alarm[rows].any())
        if kind == "still":
            counts.still, counts.still_told = counts.still + 1, counts.still_told + told
        else:
            counts.moving, counts.moving_told = counts.moving + 1, counts.moving_told + told
        as_turn = int((alarm & (decisions.turns == 1))[rows].any())
        if kind == "turning":
            counts.turning, counts.turning_told = counts.turning + 1, counts.turning_told + as_turn
        if kind == "along":
            counts.along, counts.along_told = counts.along + 1, counts.along_told + as_turn


def thresholds_of(recordings, decided):
    """A hundred thresholds, as many scores between any two; none, where there are no scores."""
    scores = np.concatenate([d.score[within(r.times, r.truth.quiet + [(s.begin_s, s.end_s) for s in r.truth.slips])] for r, d in zip(recordings, decided)])
    scores = scores[~np.isnan(scores)]
    if not len(scores):
        return np.array([])
    usual = np.quantile(scores, np.linspace(0, 1, THRESHOLDS // 2))
    rare = np.quantile(scores, 1 - np.geomspace(0.2, 0.5 / len(scores), THRESHOLDS - THRESHOLDS // 2))   # most alarms are rare
    return np.unique(np.concatenate([usual, rare, [scores.max()]]))


def add_curve(recording, decisions, counts, thresholds):
    """Alarm: the score reaches the threshold."""
    score = np.nan_to_num(decisions.score, nan=-np.inf)
    at = [episodes(score >= limit, recording.times) for limit in thresholds]
    counts.curve_in_time = np.array([sum(told(s, alarms, recording.end_s)[0] == "in_time" for s in recording.truth.slips) for alarms in at])
    counts.curve_false = np.array([false_in(alarms, recording.truth.quiet) for alarms in at])


def threshold_without(counted, thresholds, block):
    """The threshold with the least mean of missed slips and of recordings' quiet intervals with an alarm, over the other blocks."""
    others = [c for c in counted if c.block != block] or counted
    slips, quiet = sum(c.slips for c in others), sum(c.quiet or c.slips for c in others)
    missed = 1 - sum(c.curve_in_time for c in others) / slips if slips else np.zeros(len(thresholds))
    false = sum(np.minimum(c.curve_false, 1) for c in others) / max(1, quiet)
    return float(thresholds[np.argmin(missed + false)])


def judge(recordings, decided):
    """The Counts of each recording. Where a detector decides nothing itself, its threshold comes from the other blocks' recordings."""
    thresholds = thresholds_of(recordings, decided)
    counted = [Counts(r.block, slips=len(r.truth.slips), quiet=int(bool(r.truth.quiet) and not r.truth.slips)) for r in recordings]
    for recording, decisions, counts in zip(recordings, decided, counted):
        add_curve(recording, decisions, counts, thresholds)
    limits = {c.block: threshold_without(counted, thresholds, c.block) for c in counted} if len(thresholds) else {}
    found = []
    for recording, decisions, curve in zip(recordings, decided, counted):
        alarm = decisions.alarm
        if alarm is None:
            alarm = np.nan_to_num(decisions.score, nan=-np.inf) >= limits.get(recording.block, np.inf)
        counts = count(recording, decisions, alarm)
        counts.curve_in_time, counts.curve_false = curve.curve_in_time, curve.curve_false
        found.append(counts)
    return found
