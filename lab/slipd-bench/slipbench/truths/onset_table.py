"""Phases and onsets of motion from a table that somebody made of each recording, one line each.

Options: file, key: the table and its column of names; the columns kind (of them slip and still count), contact, lift, end, dropped, onset and
told (the earliest of these that are there). early_s and late_s: an alarm so long before the onset and after `told` tells the slip. marker, centre_m: also the seconds of marker_motion, but for
kinds among no_seconds."""
import csv

import numpy as np

from . import marker_motion
from .moved import judged


def number(text):
    return float(text) if text else None


def rows_of(folder, options):
    with open(folder / options["file"], newline="") as lines:
        return {row[options["key"]]: row for row in csv.DictReader(lines)}


def of(recording, folder, options):
    row = rows_of(folder, options)[recording.name]
    end = number(row[options["dropped"]]) or number(row[options["end"]])
    contact = number(row[options["contact"]])
    truth = judged(row[options["kind"]], contact, end, number(row[options["onset"]]), [number(row[column]) for column in options["told"]], options)
    if row[options["kind"]] not in options.get("no_seconds", ()) and "marker" in options:
        poses = marker_motion.poses_of(folder / recording.name / options["marker"])
        truth.seconds = marker_motion.seconds_of(poses, recording.rate_hz, number(row[options["lift"]]), end, np.array(options["centre_m"]))
    return truth
