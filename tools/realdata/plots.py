"""The pictures of docs/real-sensors.md, by gnuplot. None is of a single recording of the pillars: these have no licence."""
import math
import shutil
import subprocess

from . import recordings as rec

HEAD = "set terminal svg size 900,{height} font 'sans,12' background 'white'\nset output '{name}.svg'\nset grid\n"
SHOWN_S = 1.5  # after the label
COLOURS = ["#1f4e8c", "#c8553d", "#588b3a", "#8c5fa8"]


def draw(folder, name, script):
    gnuplot = shutil.which("gnuplot")
    if gnuplot is None:
        raise SystemExit("real: gnuplot is missing: apt install gnuplot-nox")
    subprocess.run([gnuplot], input=script, text=True, cwd=folder, check=True)


def block(rows):
    lines = "\n".join(" ".join("NaN" if v is None else f"{v:.6g}" for v in row) for row in rows)
    return f"{lines}\ne\n"


def tick_step(top):
    """About four ticks up to `top`, a round number apart."""
    exponent = 10 ** math.floor(math.log10(top / 4))
    return next(step * exponent for step in (1, 2, 5, 10) if step * exponent >= top / 5)


def eflesh_roc(result, folder):
    script = HEAD.format(height=480, name="eflesh-roc")
    script += ("set size square\nset xrange [-0.02:1.02]\nset yrange [-0.02:1.02]\nset key outside right\n"
               "set xlabel 'share of still sequences with an alarm'\nset ylabel 'share of slips with an alarm'\nplot ")
    curves = [f"'-' using 1:2 with lines lw 2 lc rgb '{colour}' title '{name}'"
              for name, colour in zip(result.statistics, COLOURS[1:])]
    marks = [f"'-' using 1:2 with points pt {mark} ps 1.6 lc rgb '{COLOURS[0]}' title 'slipd: {text}'"
             for text, mark in (("slides", 7), ("slides or is disturbed", 5))]
    chance = "x with lines dt 2 lc rgb 'gray' title 'chance'"
    script += ", ".join(curves + marks + [chance]) + "\n"
    script += "".join(block(result.curve(name)) for name in result.statistics)
    script += "".join(block([result.point(found)]) for found in (result.slid, result.told))
    draw(folder, "eflesh-roc", script)


def uskin_course(runs, folder):
    slip = [run for run in runs if run.label_s is not None]
    script = HEAD.format(height=280 * len(slip), name="uskin-slip")
    script += f"set multiplot layout {len(slip)},1\nset key outside right\nset yrange [0:1.05]\nset xlabel 'time, s'\n"
    for run in slip:
        script += f"set title 'fingertip {run.sensor[-1]}' noenhanced\nset xrange [0:{run.label_s + SHOWN_S}]\n"
        most = max(run.recording.normal())
        drop = run.values["P drops"]
        course = [[float(r["time_s"]), rec.number(r["gamma"]), p / most, ratio, max(0.0, fall), 1 if rec.slips(r) else 0,
                   1 if rec.slides(r) else 0]
                  for r, p, ratio, fall in zip(run.rows, run.recording.normal(), run.values["Q/P over a given friction"], drop)]
        script += f"set arrow 1 from {run.label_s},0 to {run.label_s},1.05 nohead dt 2 lw 2 lc rgb 'black'\n"
        script += ("plot '-' using 1:6 with filledcurves y1=0 lc rgb '#f4cccc' title 'slipd: alert slip', "
                   f"'-' using 1:2 with lines lw 2 lc rgb '{COLOURS[0]}' title 'slipd: margin', "
                   f"'-' using 1:3 with lines lc rgb '{COLOURS[2]}' title 'P over its peak', "
                   f"'-' using 1:4 with lines lc rgb '{COLOURS[1]}' title 'Q/P', "
                   f"'-' using 1:5 with lines lc rgb '{COLOURS[3]}' title 'fall of P', "
                   "NaN with lines dt 2 lw 2 lc rgb 'black' title 'label'\n")
        script += "".join(block(course) for _ in range(5))
    draw(folder, "uskin-slip", script + "unset multiplot\n")


def pillars_false(result, folder):
    """Share of quiet grasps with an alarm over the threshold, all grasps together."""
    names = list(result.statistics)
    script = HEAD.format(height=300, name="pillars-false")
    script += f"set multiplot layout 1,{len(names)}\nset yrange [-5:105]\nunset key\nset ylabel 'quiet grasps with an alarm, %'\n"
    labels = {"Q/P over a given friction": "friction given", "P drops": "fall of P, share", "vibration": "vibration over P"}
    slipd = 100 * result.false["slipd"] / result.quiet
    for name, colour in zip(names, COLOURS[1:]):
        values = sorted(result.statistics[name])
        top = values[-1] * 1.1
        steps = [[0.0, 100.0]]
        for i, value in enumerate(values):
            left = 100 * (len(values) - i) / len(values)
            steps += [[value, left], [value, 100 * (len(values) - i - 1) / len(values)]]
        steps.append([top, 0.0])
        script += (f"set title '{name}'\nset xlabel '{labels[name]}'\nset xrange [0:{top:.4g}]\nset xtics {tick_step(top):.4g}\n"
                   f"plot '-' using 1:2 with lines lw 2 lc rgb '{colour}', {slipd:.4g} with lines dt 2 lw 2 lc rgb '{COLOURS[0]}'\n")
        script += block(steps)
    draw(folder, "pillars-false", script + "unset multiplot\n")
