"""A label in each row: the first 1 is the onset of a slip.

Options: file, column; early_s and late_s: an alarm so long before and after the onset tells it."""
import csv

from ..recording import Slip, Truth


def of(recording, folder, options):
    with open(folder / recording.name / options["file"], newline="") as lines:
        labels = [float(row[options["column"]]) > 0 for row in csv.DictReader(lines)]
    if not any(labels):
        return Truth(quiet=[(0.0, recording.end_s)], held=[(0.0, recording.end_s)])
    first = labels.index(True)
    last = len(labels) - 1 - labels[::-1].index(True)
    onset = float(recording.times[first])
    quiet = [(0.0, onset - options["early_s"])]
    unsafe = [(onset, float(recording.times[min(last, len(recording.times) - 1)]))]
    return Truth(slips=[Slip(quiet[0][1], onset + options["late_s"], onset)], quiet=quiet, held=quiet, unsafe=unsafe)
