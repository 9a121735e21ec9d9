"""The picture of a set, by gnuplot: what each detector misses against its false alarms, and how late it tells."""
import shutil
import subprocess

import numpy as np

from .figures import curve_of
from .measures import MOST_PER_HOUR
from .sets import WrongUse

COLOURS = ["#1f4e8c", "#c8553d", "#588b3a", "#8c5fa8", "#d19a2a", "#3d9a9a", "#555555"]
LATEST_S = 2.0


def steps_of(result):
    """The least share missed (per cent) over false alarms per hour."""
    missed, false = curve_of(result.counted, np.ones(len(result.counted), int))
    order = np.argsort(false, kind="stable")
    points, least = [(0.0, 100.0)], 1.0
    for f, m in zip(false[order], missed[order]):
        if m < least:
            points += [(f, 100 * least), (f, 100 * m)]
            least = m
    return [*points, (2 * MOST_PER_HOUR, 100 * least)]


def latencies_of(result):
    """The share of slips (per cent) that were told so long after their onset."""
    slips = sum(c.slips for c in result.counted)
    late = sorted(value for c in result.counted for value in c.latencies)
    points = [(-LATEST_S, 0.0)]
    for i, value in enumerate(late):
        points += [(value, 100 * i / slips), (value, 100 * (i + 1) / slips)]
    return [*points, (LATEST_S, 100 * len(late) / slips)]


def block(points):
    return "".join(f"{x:.6g} {y:.6g}\n" for x, y in points) + "e\n"


def draw(file, results):
    gnuplot = shutil.which("gnuplot")
    if gnuplot is None:
        raise WrongUse("gnuplot is missing: apt install gnuplot-nox")
    timed = any(c.latencies for r in results for c in r.counted)
    colours = dict(zip([r.detector for r in results], COLOURS * 9))
    script = (f"set terminal svg size {1000 if timed else 640},420 font 'sans,12' background 'white'\nset output '{file.name}'\nset grid\n"
              f"set multiplot layout 1,{2 if timed else 1}\nset yrange [-3:103]\nset xrange [-10:{MOST_PER_HOUR}]\n"
              "set xlabel 'false alarms per hour of holding'\nset ylabel 'slips not told in time, %'\n"
              f"{'unset key' if timed else 'set key outside right'}\n")
    lines = [f"'-' using 1:2 with lines lw 2 lc rgb '{colours[r.detector]}' title '{r.detector}'" for r in results]
    marks = [f"'-' using 1:2 with points pt 7 ps 1.1 lc rgb '{colours[r.detector]}' notitle" for r in results]
    script += "plot " + ", ".join(lines + marks) + "\n" + "".join(block(steps_of(r)) for r in results)
    script += "".join(block([(min(r.figures["false alarms"].value, MOST_PER_HOUR), 100 - 100 * r.figures["in time"].value)]) for r in results)
    if timed:
        script += (f"set key outside right\nset xrange [-1:{LATEST_S}]\nset xlabel 'alarm after the onset, s'\nset ylabel 'slips, %'\n"
                   "plot " + ", ".join(lines) + "\n" + "".join(block(latencies_of(r)) for r in results))
    subprocess.run([gnuplot], input=script + "unset multiplot\n", text=True, cwd=file.parent, check=True)
