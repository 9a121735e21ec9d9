"""Figures of a set and a detector from the counts of its recordings, with intervals: the middle 90 % of DRAWS draws of blocks with replacement,
seed SEED. Fewer than LEAST_BLOCKS have none: their draws say little of blocks that were not recorded."""
from dataclasses import dataclass

import numpy as np

from .measures import MOST_PER_HOUR

DRAWS = 1000
SEED = 1
LEAST_BLOCKS = 5
NAMES = {"in time": "share of slips", "late": "share of slips", "standing": "share of slips", "missed": "share of slips",
         "latency 10 %": "s", "latency 50 %": "s", "latency 90 %": "s", "false alarms": "per hour of holding",
         "quiet with alarm": "share of quiet recordings", "held in alarm": "share of holding", "answered": "share of time", "margin": "share of holding",
         "called safe": "share of sliding", "gamma bias": "", "gamma error": "", "bound": "area under the ROC of gamma_low, before slips against holds",
         "seconds moving": "share told", "seconds still": "share told", "seconds turning": "share told as rotation", "seconds along": "share told as rotation", "area": f"mean share missed, up to {MOST_PER_HOUR} false alarms per hour"}


@dataclass
class Figure:
    value: float
    low: float
    high: float


def ratio(a, b):
    return a / b if b > 0 else np.nan


def curve_of(counted, weights):
    """Shares missed and false alarms per hour at each threshold, and of the decisions themselves as the last point."""
    slips = sum(w * c.slips for w, c in zip(weights, counted))
    hours = sum(w * c.held_s for w, c in zip(weights, counted)) / 3600
    told = sum(w * np.append(c.curve_in_time, c.in_time) for w, c in zip(weights, counted))
    false = sum(w * np.append(c.curve_false, c.false) for w, c in zip(weights, counted))
    return (1 - told / slips, false / hours) if slips and hours else (np.full(len(told), np.nan), np.full(len(false), np.nan))


def area(missed, false):
    """Mean over 0 … MOST_PER_HOUR of the least share missed with at most so many false alarms; with none allowed, a silent detector misses all."""
    if np.isnan(missed).any():
        return np.nan
    order = np.argsort(false, kind="stable")
    false, missed = np.append(false[order], np.inf), np.minimum.accumulate(np.append(missed[order], 0))
    total, at, least = 0.0, 0.0, 1.0
    for limit, share in zip(false, missed):
        total += least * (min(limit, MOST_PER_HOUR) - at)
        at = min(limit, MOST_PER_HOUR)
        least = min(least, share) if np.isfinite(limit) else least
    return total / MOST_PER_HOUR


def roc_area(greater, less):
    """How often one of `greater` is above one of `less`; equal ones count half."""
    if not len(greater) or not len(less):
        return np.nan
    return float(((greater[:, None] > less).mean() + (greater[:, None] == less).mean() / 2))


def figures_once(counted, weights):
    def total(key):
        return sum(w * getattr(c, key) for w, c in zip(weights, counted))
    slips, held = total("slips"), total("held_s")
    latencies = np.concatenate([np.repeat(c.latencies, w) for w, c in zip(weights, counted)])
    errors = np.concatenate([np.repeat(c.gamma_errors, w) for w, c in zip(weights, counted)])
    found = {key.replace("_", " "): ratio(total(key), slips) for key in ("in_time", "late", "standing")}
    found["missed"] = 1 - sum(found.values())
    found.update({f"latency {q} %": np.quantile(latencies, q / 100) if len(latencies) else np.nan for q in (10, 50, 90)})
    found["false alarms"] = ratio(total("false"), held / 3600)
    found["quiet with alarm"] = ratio(total("quiet_alarmed"), total("quiet"))
    found["held in alarm"] = ratio(total("alarmed_s"), held)
    found["answered"] = ratio(total("answered_s"), total("judged_s"))
    found["margin"] = ratio(total("margin_s"), held)
    found["called safe"] = ratio(total("called_safe_s"), total("unsafe_s"))
    found["gamma bias"] = errors.mean() if len(errors) else np.nan
    found["gamma error"] = np.abs(errors).mean() if len(errors) else np.nan
    found["bound"] = roc_area(*(np.concatenate([np.repeat(getattr(c, key), w) for w, c in zip(weights, counted)]) for key in ("low_held", "low_before")))
    found.update({f"seconds {kind}": ratio(total(f"{kind}_told"), total(kind)) for kind in ("moving", "still", "turning", "along")})
    found["area"] = area(*curve_of(counted, weights))
    return found


def figures(counted):
    """By name a Figure; NaN where there is nothing to count."""
    blocks = sorted({c.block for c in counted})
    place = np.array([blocks.index(c.block) for c in counted])
    random = np.random.default_rng(SEED)
    once = figures_once(counted, np.ones(len(counted), int))
    draws = [figures_once(counted, np.bincount(random.integers(len(blocks), size=len(blocks)), minlength=len(blocks))[place]) for _ in range(DRAWS)]
    found = {}
    for name, value in once.items():
        values = np.array([draw[name] for draw in draws])
        known = values[~np.isnan(values)]
        low, high = np.quantile(known, [0.05, 0.95]) if len(known) and len(blocks) >= LEAST_BLOCKS else (np.nan, np.nan)
        found[name] = Figure(float(value), float(low), float(high))
    return found
