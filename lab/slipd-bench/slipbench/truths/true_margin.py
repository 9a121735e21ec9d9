"""The true margin of each row, as simulated sensors have it: a slip begins where it is 0 while the object is held.

Options: safe: the grasp is quiet until the margin falls below it, and an alarm from there on is in time; late_s: after the slip began."""
import numpy as np

from ..recording import Slip, Truth

HELD = 0.5   # share of the median P: below it the object is being let go of


def of(recording, _, options):
    gamma, times = recording.truth.gamma, recording.times
    normal = sum(recording.normal(sensor) for sensor in recording.values)
    touched = np.flatnonzero(~np.isnan(gamma))
    if not len(touched):
        return Truth(gamma=gamma)
    after = np.arange(len(times)) > touched[len(touched) // 10]   # a light touch has no margin to speak of
    unsafe = np.flatnonzero(after & (gamma < options["safe"]))
    until = float(times[unsafe[0] - 1] if len(unsafe) else times[touched[-1]])
    quiet = [(0.0, until)]
    slides = np.flatnonzero(after & (gamma <= 0) & (normal > HELD * np.median(normal[touched])))
    truth = Truth(quiet=quiet, held=[(float(times[touched[0]]), until)], gamma=gamma)
    if len(slides):
        onset = float(times[slides[0]])
        truth.slips = [Slip(until, onset + options["late_s"], onset)]
        truth.unsafe = [(onset, float(times[slides[-1]]))]
    return truth
