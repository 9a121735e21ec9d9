"""One label a recording: slip or none, by a table. Where the slip begins is not known.

Options: file, key, column: the table and its columns of names and of labels. quiet_s: every recording is quiet so long from its beginning.
kept_out: names that are neither."""
import csv

from ..recording import Slip, Truth


def of(recording, folder, options):
    with open(folder / options["file"], newline="") as lines:
        labels = {row[options["key"]]: row[options["column"]] == "1" for row in csv.DictReader(lines)}
    quiet_s = options.get("quiet_s", 0.0)
    if recording.name not in labels or recording.name in options.get("kept_out", ()):
        return Truth()
    if not labels[recording.name]:
        return Truth(quiet=[(0.0, recording.end_s)], held=[(0.0, recording.end_s)])
    early = [(0.0, quiet_s)] if quiet_s else []
    return Truth(slips=[Slip(quiet_s, recording.end_s)], quiet=early, held=early)
