"""Data sets: a JSON file each (docs/slipd-bench.md), its files checked by hash, read by a reader, judged by a generator of truth."""
import hashlib
import importlib
import json
from pathlib import Path

SETS = Path(__file__).resolve().parents[1] / "sets"
KEYS = {"title", "source", "sha256", "reader", "truth", "recordings", "sensor", "sensors", "grid", "unit", "channels", "rate_hz",
        "least_normal", "block", "blocks_are"}
OPTIONAL = {"zero_from_s", "grid", "least_normal", "block", "blocks_are", "remark", "folder", "onset", "expect"}


class WrongUse(Exception):
    """Something that whoever called slipd-bench can put right."""


def names():
    return sorted(file.stem for file in SETS.glob("*.json"))


def describe(name):
    """The description of a shipped set, or of a file."""
    file = Path(name) if name.endswith(".json") else SETS / f"{name}.json"
    if not file.is_file():
        raise WrongUse(f"{name}: no such set; there are {', '.join(names())}, or name a file")
    try:
        spec = json.loads(file.read_text())
    except json.JSONDecodeError as error:
        raise WrongUse(f"{file}:{error.lineno}: {error.msg}") from None
    missing, unknown = sorted(KEYS - OPTIONAL - set(spec)), sorted(set(spec) - KEYS - OPTIONAL)
    if missing or unknown:
        raise WrongUse(f"{file}: " + "; ".join(
            [f"{key} is missing" for key in missing] + [f"{key} is not known, see docs/slipd-bench.md" for key in unknown]))
    return {"name": file.stem, **spec}


def has(spec, data):
    """Whether one of the folders has a set's files."""
    return any((each / spec.get("folder", spec["name"])).is_dir() for each in data)


def folder_of(spec, data):
    """Where a set's files are: NAME in one of the folders `data`."""
    if not has(spec, data):
        raise WrongUse(f"no {spec.get('folder', spec['name'])} in {', '.join(map(str, data))}; it comes from {spec['source']['url']}, see {spec['name']}.json")
    return next(each / spec.get("folder", spec["name"]) for each in data if has(spec, [each]))


def digest(folder):
    """SHA-256 over the names and contents of all data files, in order of their names."""
    total = hashlib.sha256()
    for file in sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix != ".md" and p.name != "LICENSE"):
        total.update(str(file.relative_to(folder)).encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()


def part(kind, name):
    """The module of a reader or of a generator of truth."""
    try:
        return importlib.import_module(f"slipbench.{kind}.{name}")
    except ModuleNotFoundError as error:
        if error.name != f"slipbench.{kind}.{name}":
            raise
        raise WrongUse(f"{kind[:-1]} {name}: there is no slipbench/{kind}/{name}.py") from None


def load(spec, data, any_files=False):
    """The recordings of a set with their truth. any_files: of other files than those described, too."""
    folder = folder_of(spec, data)
    found = digest(folder)
    if spec["sha256"] and found != spec["sha256"] and not any_files:
        raise WrongUse(f"{folder}: not the files that {spec['name']}.json describes (sha256 {found}); --any-files takes them all the same")
    truth = part("truths", spec["truth"]["generator"])
    recordings = list(part("readers", spec["reader"]).recordings(folder, spec))
    if not recordings:
        raise WrongUse(f"{folder}: no recording is called {spec['recordings']}")
    for recording in recordings:
        recording.truth = truth.of(recording, folder, spec["truth"])
    return recordings
