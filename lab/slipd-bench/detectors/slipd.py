"""slipd.py SLIPLAB SCENES: slipd itself, through `sliplab replay`, which is the chain of the daemon.

Alarm: the grasp's alert is `slip`, or it is told to slide; without a grasp, either of any sensor. Answered: a margin, or whether it slides.
Score: 1 in an alarm, else 1 - gamma_low where there is one."""
import csv
import io
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SLIDES = ("translation", "rotation")


def scene_for(about, scenes):
    """The shipped scene of this sensor with the recording's rate and zero."""
    scene = json.loads(re.sub(r"^\s*//.*$", "", (scenes / f"{about['sensor']}.json").read_text(), flags=re.MULTILINE))
    scene.pop("$schema", None)
    for sensor in scene["sensors"]:
        sensor["rate_hz"] = about["rate_hz"]
        options = sensor["options"]
        for key in ("bias", "taxels", "file"):
            options.pop(key, None)
        zero = about["sensors"][sensor["name"]].get("zero")
        if zero and any(zero):
            options["bias"] = zero
        elif "zero_from_s" in about:
            options["zero_from_s"] = about["zero_from_s"]
        options["file"] = f"{sensor['name']}.csv"
    return scene


def write_files(folder, about, rows):
    for name, sensor in about["sensors"].items():
        count = len(sensor["taxels_mm"])
        with open(folder / f"{name}.csv", "w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["time"] + [f"txl{k + 1}_{axis}" for k in range(count) for axis in "xyz"])
            table.writerows([row["t"], *(value for taxel in row[name] for value in taxel)] for row in rows)


def replayed(sliplab, scenes, about, rows):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_files(folder, about, rows)
        (folder / "scene.json").write_text(json.dumps(scene_for(about, scenes)))
        files = [word for sensor in about["sensors"] for word in ("--file", f"{sensor}={folder / sensor}.csv")]
        done = subprocess.run([sliplab, "replay", "--scene", folder / "scene.json", "--estimates", "-", *files], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return csv.DictReader(io.StringIO(done.stdout))


def alarms(row):
    return row["alert"] == "slip" or row["sliding"] in SLIDES


def answers(row):
    return row["state"] == "ok" or row["sliding"] in (*SLIDES, "none")


def decision(row_of):
    """Of the estimates of one frame."""
    alarm = any(map(alarms, row_of))
    low = [float(row["gamma_low"]) for row in row_of if row["gamma_low"]]
    gamma = [float(row["gamma"]) for row in row_of if row["gamma"]]
    known = alarm or any(map(answers, row_of))
    return {"slip": alarm if known else None, "score": 1.0 if alarm else 1 - min(low) if low else 0.0 if known else None,
            "gamma": min(gamma) if gamma else None, "gamma_low": min(low) if low else None,
            "kind": next((row["sliding"] for row in row_of if row["sliding"] in SLIDES), None)}


def main():
    sliplab, scenes = sys.argv[1], Path(sys.argv[2])
    about = json.loads(sys.stdin.readline())
    by_time = {}
    rows = list(replayed(sliplab, scenes, about, [json.loads(line) for line in sys.stdin]))
    of_grasp = [row for row in rows if row["sensor"] not in about["sensors"]]
    for row in of_grasp or rows:
        by_time.setdefault(float(row["time_s"]), []).append(row)
    for t in sorted(by_time):
        print(json.dumps({"t": t, **decision(by_time[t])}))


if __name__ == "__main__":
    main()
