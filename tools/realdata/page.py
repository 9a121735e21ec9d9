"""docs/real-sensors.md."""
from . import eflesh, pillars, plots, recordings, rivals, uskin, uskin_flat
from .scores import area, balanced, best_balanced


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def per_cent(share):
    return f"{100 * share:.0f} %"


def lead(run, name):
    if run.false[name]:
        return "too early"
    if run.leads[name] is None:
        return "none"
    seconds = run.leads[name]
    return f"{abs(seconds):.2f} s {'before' if seconds >= 0 else 'after'}"


def early_pull(result):
    if not result.safe:
        return ""
    return f", in the first {result.safe_until_s:.2f} s of the pull, at Q/P of up to {result.safe_load:.2f}"


def pillars_section(result):
    rows = []
    for name in ("slipd", *rivals.RIVALS):
        limit = "defaults" if name == "slipd" else f"{pillars.LIMITS[name]:g}"
        turned = result.turned.get(name)
        rows.append([name, limit, f"{result.false[name]} of {result.quiet}", result.closing[name],
                     "no" if turned is None else f"{turned:.2f} s after"])
    return f"""## Finger of 3 x 3 pillars, newtons

38 recordings of 3 x 3 pillars (PapillArray) at up to 500 rows a second, from a public repository without a licence; only sums over them are
here. In {result.quiet} grasps a parallel gripper closes on an object, holds it for about 3 s and releases it, and nobody pulls: each alarm
from contact to release is false. In one an object is turned in the grip; {result.cables} are of a cable that hooks on the pillars and is
pulled. Scene `pillars-3x3`; slipd has the range of friction of the scene (0.3–1) and no other knowledge.

{table(["detector", "threshold", "quiet grasps with an alarm", "of these while closing", "turned object: alarm"], rows)}

* A margin (state `ok`) comes in {per_cent(result.with_margin / max(1, result.held))} of the rows of the middle half of the holds.
* Cables: `no_contact` with more than {pillars.SHEAR_N:g} N of shear in {result.lost_contact} rows; a margin above {pillars.SAFE_MARGIN:g}
  while pulled in {result.safe} rows{early_pull(result)}.

The plain detectors at every threshold; the dashed line is slipd at its defaults:

![share of quiet grasps with an alarm over the threshold of each plain detector](real-sensors/pillars-false.svg)
"""


def uskin_section(runs):
    head = ["detector", *(f"{run.trial[:10]} {run.trial[11:16].replace('-', ':')}, fingertip {run.sensor[-1]}{', slip' if run.label_s is not None else ''}" for run in runs)]
    rows = [[name, *("silent" if run.label_s is None and not run.false[name] else lead(run, name) for run in runs)]
            for name in ("slipd", *rivals.RIVALS)]
    with_margin = [sum(r["state"] == "ok" for r in run.rows) / len(run.rows) for run in runs]
    return f"""## Two magnetic fingertips of 4 x 4 taxels, counts with a zero

Three grasps with two XELA uSkin fingertips at 60 rows a second (github.com/imanlab/proactive-slip-control, MIT): an arm lifts and moves an
object; in one grasp it slips, labelled by a camera at about 5 mm of motion. Scene `uskin-4x4`. slipd has its defaults. The plain detectors
have the best threshold that hindsight gives: the least one, of each fingertip, that stays silent in both grasps without a slip. *too early*:
more than {uskin.EARLY_S:g} s before the label.

{table(head, rows)}

slipd gives a margin in {per_cent(min(with_margin))} to {per_cent(max(with_margin))} of the rows. Counts are no newtons, so a margin is right
only in as far as x, y and z have equal scales.

![both fingertips in the grasp that slips](real-sensors/uskin-slip.svg)
"""


def eflesh_section(result):
    rows = [["slipd: slides", "defaults", f"{balanced(result.slid, result.labels):.3f}", ""],
            ["slipd: slides or is disturbed", "defaults", f"{balanced(result.told, result.labels):.3f}", ""]]
    for name in eflesh.PLAIN:
        points = result.curve(name)
        rows.append([name, "the best of all", f"{best_balanced(points):.3f}", f"{area(points):.3f}"])
    slips = sum(result.labels)
    return f"""## Ten magnetometers under a printed skin, raw

{len(result.labels)} sequences of 3 s, {slips} of them with a slip (github.com/notvenky/eFlesh, MIT): an object is held, and in some pulled
until it slips. Raw microtesla without zero and layout, about 100 rows a second. Scene `eflesh`. There are no forces, so there is no
margin and no Q/P; slipd's detection of sliding works on the readings' course ([methods.md](methods.md) §30). The authors of the data report 95 %
with a classifier that was trained on it. The plain detectors have the threshold that is best for exactly these sequences.

{table(["detector", "threshold", "balanced accuracy", "area under the ROC"], rows)}

*moved since the hold* asks whether somebody pulled; it has no way to tell a pull that holds from a slip.

![receiver operating characteristic of each detector](real-sensors/eflesh-roc.svg)
"""


def counted(pair):
    return f"{pair[0]} of {pair[1]}"


def uskin_flat_section(result):
    told = result.figures["told"]
    rows = [[name, f"{f['in time']} of {f['slips']}", f["late"], f["standing"], f["missed"], f"{f['delay, median']:.2f} s", f["before 1 mm"],
             f"{f['still with alarm']} of {f['still']}", per_cent(f["hold in alarm"]), f"{f['balanced']:.2f}"] for name, f in told.items()]
    counts, margin = result.figures["seconds"]["counts"], result.figures["margin"]
    margins = [[source, per_cent(margin[f"{source}: with a margin"]), f"{margin[f'{source}: gamma_low, AUC']:.2f}"]
               for source in (*uskin_flat.SENSORS, uskin_flat.GRASP)]
    return f"""## Two magnetic fingertips of 4 x 4 taxels, and a camera

{len(result.grasps)} grasps with two XELA uSkin fingertips (github.com/imanlab/tactile_prediction_flat_dataset, commit ed8c1a0; no licence, so that only
sums over them are here). A camera on the hand sees how the object moves in it: {told["the grasp's alert"]["slips"]} objects slip (more than 5 mm or 10
degrees, or they drop), {told["the grasp's alert"]["still"]} stay within 2 mm and 3 degrees; the others creep, or bend camera and fingers, and count nowhere in the
table. Rows come at 38 to 46 a second, of which the sensors fill about 10 with new values. Scene `uskin-4x4` with the recording's rate and its own zero
(`zero_from_s` {uskin_flat.ZERO_S:g}), friction unknown, all else by default. Measured on {recordings.today()} at {recordings.commit()} by `tools/real`.

*in time*: an alarm begins between {uskin_flat.EARLIEST_S:g} s before 1 mm of motion and {uskin_flat.LATEST_S:g} s after 2 mm or 10 degrees. *standing*: it was raised before and
did not end. *delay*: after 1 mm. *still grasps with an alarm*: from contact to the end. *balanced*: of grasps.

{table(["alarm", "slips in time", "late", "standing", "missed", "delay, median", "before 1 mm", "still grasps with an alarm", "share of their hold", "balanced"], rows)}

* By seconds of the hold, by the grasp's `sliding`: told in {counted(counts["moving"])} in which the object moves by more than 2 mm, or turns, and in {counted(counts["still"])} with less than 0.5 mm
  (balanced accuracy {result.figures["seconds"]["balanced"]:.2f}). Of seconds in which the object only turns, {counted(counts["turning"])} have `rotation` in them and
  {counts["turning called translation"][0]} `translation`; some have both.
* Margins, in still holds, and how well `gamma_low` tells the {uskin_flat.BEFORE_S:g} s before a slip from still holds (area under the ROC; 0.5 is chance):

{table(["", "rows with a margin", "area"], margins)}

* **There is no margin to speak of.** Pressing alone makes |Q|/P of 0.1 to 0.18 here, which is as much as the least friction that an object may have, and friction
  stays unknown until something slides. So nothing is foretold on purpose: an alarm comes with the slide.
* Where numbers come from: the detection's limit of one finger was set with the recordings of 2022 in the section above. Of the numbers that came since, 1/√2 for
  two fingers is that of a mean, a grip that relaxes by 10 % moves a pattern by as much as the limit that was there, and a second without a slide, which ends an
  alert, was chosen beforehand. But the first two are among several that were tried on these recordings, and so are the limits of the truth by seconds: this
  table does not judge them. {75 - len(result.grasps)} other recordings of the same source were not looked at, and only they can.
"""


FAILS = """## Where it fails

* **What slides with an unchanged pattern is not seen.** A flat, even object that slides without a change of P shows neither in the pattern nor
  in the forces; then only the margin warns, and for that friction has to be known.
* **Raw counts have no margin**, and a steady pull at an object that sticks looks like the beginning of a slide. Give the sensor a zero where
  this matters.
* **Friction that is only known as a range** gives a margin of that range (`gamma_low` is its safe end). It warns early, and an alert does not
  say that the object slides; `alert_cause` tells both apart.
* **Labels are late.** The camera of the second data set labels a slip at 5 mm of motion; motion above 1 mm began 0.1–0.2 s earlier.
* **Few slides.** Beside the grasps with a camera all data together have four slides with forces. The table of [alerts.md](alerts.md) has thousands, of simulated sensors.
"""


def write(found, docs):
    """`found`: the results by data set; a data set that is missing leaves its section out."""
    pictures = docs / "real-sensors"
    pictures.mkdir(parents=True, exist_ok=True)
    sections = []
    if "pillars" in found:
        plots.pillars_false(found["pillars"], pictures)
        sections.append(pillars_section(found["pillars"]))
    if "uskin" in found:
        plots.uskin_course(found["uskin"], pictures)
        sections.append(uskin_section(found["uskin"]))
    if "eflesh" in found:
        plots.eflesh_roc(found["eflesh"], pictures)
        sections.append(eflesh_section(found["eflesh"]))
    if "uskin-flat" in found:
        sections.insert(min(2, len(sections)), uskin_flat_section(found["uskin-flat"]))
    (docs / "real-sensors.md").write_text(f"""# Real sensors

Generated by `tools/real`. What slipd says of recordings of real sensors that it did not make, each through `sliplab replay`, which is
the chain of the daemon, and beside it three detectors that are common with such sensors, in the same run and on the same rows:

* **Q/P over a given friction**: alarm when the tangential over the normal force exceeds a friction that somebody gave.
* **P drops**: alarm when the normal force falls below its mean of the last {rivals.DROP_S:g} s by a share.
* **vibration**: alarm on the root mean square of fast changes of shear, over {1000 * rivals.RMS_S:.0f} ms.

slipd has one set of defaults for all of them. Nothing is trained on any of them, but some limits were set with what quiet grasps of the pillars and of the
magnetic fingertips of 2022 reach ([numbers.md](numbers.md) says it of each): figures of these two sets are not those of recordings that nobody has looked at.

{chr(10).join(sections)}
{FAILS}""")
