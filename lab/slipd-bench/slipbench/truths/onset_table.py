"""Phases and onsets of motion from a table that somebody made of each recording, one line each.

Options: file, key: the table and its column of names; the columns kind (of them slip and still count), contact, lift, end, dropped, onset and
told (the latest of these that are there). early_s and late_s: an alarm so long before the onset and after `told` tells the slip."""
import csv

from ..recording import Slip, Truth


def number(text):
    return float(text) if text else None


def rows_of(folder, options):
    with open(folder / options["file"], newline="") as lines:
        return {row[options["key"]]: row for row in csv.DictReader(lines)}


def of(recording, folder, options):
    row = rows_of(folder, options)[recording.name]
    end = number(row[options["dropped"]]) or number(row[options["end"]])
    contact = number(row[options["contact"]])
    return judged(row[options["kind"]], contact, end, number(row[options["onset"]]),
                  [number(row[column]) for column in options["told"]], options)


def judged(kind, contact_s, end_s, onset_s, told_s, options):
    """Also for a generator that measured the same itself. told_s: of several limits of motion, when each was passed; the first counts."""
    if kind == "still":
        return Truth(quiet=[(contact_s, end_s)], held=[(contact_s, end_s)])
    if kind != "slip" or onset_s is None:
        return Truth()
    passed = min(t for t in (*told_s, end_s) if t is not None)
    slip = Slip(onset_s - options["early_s"], max(passed, onset_s) + options["late_s"], onset_s)
    return Truth(slips=[slip], unsafe=[(passed, passed + options["late_s"])])
