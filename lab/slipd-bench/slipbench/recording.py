"""A recording of one grasp, and what is true of it."""
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Slip:
    """One slip. An alarm that begins in [begin_s, end_s] tells it in time; onset_s is what latency counts from, None where nobody knows it."""
    begin_s: float
    end_s: float
    onset_s: float | None = None


@dataclass
class Truth:
    """Intervals are pairs (begin, end) in s, ends included."""
    slips: list = field(default_factory=list)
    quiet: list = field(default_factory=list)     # each alarm in here is false
    held: list = field(default_factory=list)      # the hours that false alarms are counted over: contact, and no slip
    unsafe: list = field(default_factory=list)    # what is told as a safe margin in here is wrong: the object slides
    seconds: list = field(default_factory=list)   # pairs (begin, kind), kind: still, moving, turning and along (moving, and nothing but a turn, or hardly any)
    gamma: np.ndarray | None = None               # the true margin of each row, where somebody knows it


@dataclass
class Recording:
    name: str
    block: str                                    # what is drawn together for the confidence intervals: an object, a day
    rate_hz: float
    times: np.ndarray                             # of each row, s
    values: dict                                  # of each sensor: rows x taxels x channels, as the file has them
    about: dict                                   # what a detector is told before the first frame
    truth: Truth = field(default_factory=Truth)

    @property
    def end_s(self):
        return float(self.times[-1])

    def zeroed(self, sensor):
        """Rows x taxels x channels less the sensor's zero; None where nobody knows it."""
        values, told = self.values[sensor], self.about["sensors"][sensor]
        if "zero" in told:
            return values - np.reshape(told["zero"], values.shape[1:])
        if "zero_from_s" in self.about:
            return values - values[self.times < self.about["zero_from_s"]].mean(axis=0)
        return None

    def normal(self, sensor):
        """The sum of the pressing channel in each row."""
        return self.zeroed(sensor)[:, :, 2].sum(axis=1)


def within(times, intervals):
    """For each row, whether it lies in one of the intervals."""
    inside = np.zeros(len(times), bool)
    for begin, end in intervals:
        inside |= (times >= begin) & (times <= end)
    return inside
