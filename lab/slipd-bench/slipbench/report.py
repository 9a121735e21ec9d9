"""Tables of results: on the terminal, as CSV, as Markdown."""
import csv
import math

from .figures import NAMES


def number(value):
    if math.isnan(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2f}"


def with_interval(figure, show=number):
    if math.isnan(figure.value):
        return "–"
    return show(figure.value) + ("" if math.isnan(figure.low) else f" [{show(figure.low)}, {show(figure.high)}]")


def per_cent(value):
    return "–" if math.isnan(value) else f"{100 * value:.0f} %"


def slips_told(result):
    return f"{sum(c.in_time for c in result.counted)} of {sum(c.slips for c in result.counted)}"


def latency(result):
    f = result.figures
    if math.isnan(f["latency 50 %"].value):
        return "–"
    return f"{f['latency 50 %'].value:.2f} [{f['latency 10 %'].value:.2f}, {f['latency 90 %'].value:.2f}]"


def false_alarms(result):
    return f"{sum(c.false for c in result.counted)}: {with_interval(result.figures['false alarms'], lambda v: f'{v:.0f}')}"


HEAD = ["detector", "slips told in time", "share missed or late", "latency, s", "false alarms: per hour", "holds in alarm", "coverage", "margin", "area"]


def row_of(result):
    f = result.figures
    missed = type(f["in time"])(*(1 - v for v in (f["in time"].value, f["in time"].high, f["in time"].low)))
    return [result.detector, slips_told(result), with_interval(missed, per_cent), latency(result), false_alarms(result),
            per_cent(f["held in alarm"].value), per_cent(f["answered"].value), per_cent(f["margin"].value), with_interval(f["area"])]


def text_table(head, rows):
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in [head, *rows])


def markdown(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(row) + " |" for row in rows)])


def describe(spec, results):
    counted = results[0].counted
    return (f"{spec['title']}: {len(counted)} recordings in {len({c.block for c in counted})} blocks ({spec.get('blocks_are', 'recordings')}), "
            f"slips: {sum(c.slips for c in counted)}, {sum(c.held_s for c in counted):.0f} s of holding")


def write_csv(file, results):
    with open(file, "w", newline="") as lines:
        table = csv.writer(lines)
        table.writerow(["set", "detector", "figure", "unit", "value", "low", "high"])
        for result in results:
            for name, figure in result.figures.items():
                table.writerow([result.spec["name"], result.detector, name, NAMES[name], *(f"{v:.6g}" for v in (figure.value, figure.low, figure.high))])


def write_recordings(file, results):
    keys = ["block", "slips", "in_time", "late", "standing", "quiet", "false", "held_s", "alarmed_s", "judged_s", "answered_s", "margin_s", "unsafe_s", "called_safe_s"]
    with open(file, "w", newline="") as lines:
        table = csv.writer(lines)
        table.writerow(["set", "detector", "recording", *keys, "latency_s"])
        for result in results:
            for recording, counts in zip(result.recordings, result.counted):
                values = [getattr(counts, key) for key in keys]
                table.writerow([result.spec["name"], result.detector, recording.name,
                                *(f"{v:.3f}" if isinstance(v, float) else v for v in values), " ".join(f"{v:.3f}" for v in counts.latencies)])
