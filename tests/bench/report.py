"""What tools/bench has measured, as docs/performance.md and its plots. Every figure on the page comes from the results."""
import shutil
import subprocess
import pathlib

METHODS = ["moments", "svd-knn", "registered", "fit"]
HERE = pathlib.Path(__file__).resolve().parent


def number(value, digits=None):
    if value is None:
        return "–"
    if digits is None:
        digits = 0 if abs(value) >= 100 else 1 if abs(value) >= 10 else 2
    return f"{value:,.{digits}f}".replace(",", " ")


def table(head, rows):
    out = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(out + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"


def waits(of):
    return [number(of.get(f"{name}_us")) for name in ("p50", "p99", "p999", "max")]


class Results:
    def __init__(self, results):
        self.all = results
        self.machine = results["machine"]
        self.estimators = results["estimators"]["ours"]
        self.peer = {each["way"]: each for each in results["estimators"]["peer"]}
        self.paths = results["paths"]
        self.training = {each["part"]: each for each in results["training"]["ours"]}
        self.trained_by_peer = {each["part"]: each for each in results["training"]["peer"]}
        self.daemon = results["daemon"]

    def method(self, name, side):
        return self.estimators.get(f"method/{name}/{side}", {})

    def of(self, part, **like):
        return [each for each in self.daemon
                if each["part"] == part and all(each.get(key) == value for key, value in like.items())]

    def one(self, part, **like):
        found = self.of(part, **like)
        return found[0] if found else {}

    def floor(self):
        copied, found = self.estimators.get("floor/memcpy", {}), self.estimators.get("floor/search", {})
        return copied["p50_us"] + found["p50_us"] if copied and found else None


# Each target of the project: what, measured, limit, unit, whether more is better, and why it may be missed.
def targets(of):
    floor, alone, batched = of.floor(), of.peer.get("one by one", {}), of.peer.get("batched", {})
    for name in ("svd-knn", "registered"):
        ours = of.method(name, 100).get("p50_us")
        why = WHY[name]
        yield f"{name}, 100 x 100, p50 of a frame", ours, 10, "us", False, why
        if alone:
            yield f"{name} against scikit-learn one by one", alone["p50_us"] / ours, 10, "times faster", True, why
            yield f"{name} against scikit-learn batched", batched["p50_us"] / ours, 1, "times faster", True, why
        yield f"{name} against the floor", ours / floor, 2, "times the floor", False, why
    yield "moments, 100 x 100, p50", of.method("moments", 100).get("p50_us"), 6, "us", False, WHY["moments"]
    yield "fit, 100 x 100, p50", of.method("fit", 100).get("p50_us"), 300, "us", False, WHY["fit"]
    yield "fit, 16 x 16, p50", of.method("fit", 16).get("p50_us"), 30, "us", False, WHY["fit"]
    hand = of.one("latency", method="registered")
    yield "frame complete to client at 1 kHz, p50", hand.get("p50_us"), 60, "us", False, WHY["latency"]
    yield "the same, p99", hand.get("p99_us"), 250, "us", False, WHY["latency"]
    for name in METHODS[:3]:
        yield (f"frames of 100 x 100 through the pipeline, {name}", of.one("throughput", method=name).get("frames_per_s"), 20000,
               "a second", True, WHY["throughput"])
    for clients in (1, 10, 100):
        ours, redis = (of.one("queries", server=server, clients=clients, subscribers=0) for server in ("slipd", "redis"))
        if ours and redis:
            yield f"gamma against Redis GET, {clients} clients, queries", ours["per_s"] / redis["per_s"], 1, "times as many", True, WHY["queries"]
            yield f"the same, p99", ours["p99_us"] / redis["p99_us"], 1, "times as long", False, WHY["queries"]
    ours, theirs, exact = of.training["training"], of.trained_by_peer.get("training"), of.trained_by_peer.get("exact")
    if theirs:
        yield "data, SVD and index of 10000 x 16000 against scikit-learn's SVD and index of data that is there", theirs["seconds"] / ours["seconds"], 3, "times faster", True, WHY["training"]
        yield "its memory", ours["highest_mb"] / theirs["highest_mb"], 1 / 3, "of scikit-learn's", False, WHY["training"]
    if exact:
        yield "its singular values", singular_error(of), 1e-4, "relative to a full SVD's", False, WHY["training"]
    for name in ("moments", "svd-knn", "registered", "auto"):
        start = of.one("startup", method=name)
        if start:
            yield f"start-up to first estimate, {name}, {start['side']} x {start['side']}", start["p50_us"] / 1e3, 100, "ms", False, WHY["startup"]
    for locking in (False, True):
        for method, side, limit in (("moments", 4, 15), ("svd-knn", 100, 30), ("registered", 100, 30)):
            yield (f"resident memory, {method}, {side} x {side}, {'locked' if locking else 'not locked'}",
                   of.one("memory", method=method, side=side, locking=locking).get("resident_mb"), limit, "MB", False, WHY["memory"])
    for side in (4, 100):
        yield f"CPU without contact, {side} x {side} at 1 kHz", 100 * of.one("idle", side=side).get("cpu", 0), 5, "% of a core", False, WHY["idle"]


WHY = {
    "svd-knn": "where the contact is, and whether its load has only risen, is found out before anything is projected, in some ten passes over its disc",
    "registered": "a plane through the neighbours' margins on top of the search",
    "moments": "the frame is read for its noise, its place twice or more, its forces, its moments and its rings, each needing the one before",
    "fit": "each step evaluates the model and its slopes on every taxel of the disc",
    "latency": "three threads on two cores: acquire wakes estimate, estimate wakes io, io wakes the client",
    "throughput": "two threads hand each frame over, and the device's own copy of it is one more pass over its memory",
    "queries": "Asio asks the kernel anew before each wait, which Redis does not; and the sensor at 1 kHz goes on meanwhile, three threads of slipd on the cores that its clients share",
    "training": "the columns are computed, where the peer's time begins with them in memory",
    "startup": "the device's drivers are mapped, the model read and its tree built; auto tries its methods on 48 contacts first",
    "memory": "most of it is code that several processes share",
    "idle": "every frame is looked at for a contact, and each is a wake-up of two threads",
}


def singular_error(of):
    ours, exact = of.training["training"]["singular_values"], of.trained_by_peer["exact"]["singular_values"]
    return max(abs(a - b) / b for a, b in zip(ours, exact))


def verdict(value, limit, more):
    if value is None:
        return "not measured"
    reached = value >= limit if more else value <= limit
    if reached:
        return "reached"
    off = limit / value if more else value / limit
    return f"missed by {number(100 * (off - 1), 0)} %"


def target_table(of):
    rows, reasons = [], []
    for what, value, limit, unit, more, why in targets(of):
        said = verdict(value, limit, more)
        if said.startswith("missed"):
            said += f": {why}"
        digits = 6 if limit < 0.01 else None
        rows.append([what, f"{'≥' if more else '≤'} {number(limit, 4 if limit < 0.01 else None)} {unit}", number(value, digits), said])
    return table(["", "wanted", "measured", ""], rows)


def machine_text(of):
    m = of.machine
    level = ", ".join(f"{name} {size}" for name, size in m["caches"].items())
    return (f"{m['processor']}{' (a virtual machine)' if m['virtual'] else ''}, {m['cores']} cores, {level}, {m['memory_mb']} MB; "
            f"instructions {', '.join(m['vectors']) or 'of the baseline'}; kernel {m['kernel']}; {m['compiler']}; build type Release "
            f"for the baseline instruction set; no real-time privileges asked for; load average before {m['load_before']:.2f}; "
            f"{m['date']}, commit {m['commit']}. All in one run of {of.all['minutes']:.1f} minutes."
            + (" **Others used the machine when the run began: its times are longer than they would be.**" if m["load_before"] > 1 else ""))


def estimator_text(of):
    sides = [4, 8, 16, 32, 64, 100, 160, 256]
    rows = [[f"{side} x {side}"] + [number(of.method(name, side).get("p50_us")) for name in METHODS] for side in sides]
    grown = table(["taxels", *METHODS], rows)
    rows = [[name, *waits(of.method(name, 100))] for name in METHODS]
    rows += [[f"{name}, all of the chain", *waits(of.estimators.get(f"chain/{name}/100", {}))] for name in METHODS]
    rows += [[f"floor: {what}", *waits(of.estimators.get(f"floor/{name}", {}))] for name, what in
             (("memcpy", "frame (from L3) and basis (from L2), copied"), ("gemv", "basis times a full frame, Eigen, from L2"),
              ("search", "FLANN's exact search"))]
    for way, each in of.peer.items():
        parts = each.get("parts")
        more = f" ({', '.join(f'{part} {number(us)}' for part, us in parts.items())})" if parts else ""
        rows.append([f"scikit-learn, {way}{more}", *waits(each)])
    return grown, table(["100 x 100", "p50", "p99", "p99.9", "max"], rows)


def client_rows(of):
    for each in of.of("queries"):
        if "skipped" in each:
            continue
        heard = number(each.get("heard_per_s"), 0) if each.get("heard_per_s") else ""
        yield [each["server"], each["clients"], each["subscribers"], number(each["per_s"], 0), *waits(each)[:3], heard]


def plots(of, docs, folder):
    gnuplot = shutil.which("gnuplot")
    if gnuplot is None:
        return False
    out = docs / "performance"
    out.mkdir(parents=True, exist_ok=True)

    def data(name, rows):
        (folder / f"{name}.dat").write_text("\n".join(" ".join("NaN" if v is None else str(v) for v in row) for row in rows) + "\n")
    data("taxels", [[side * side] + [of.method(name, side).get("p50_us") for name in METHODS] for side in (4, 8, 16, 32, 64, 100, 160, 256)])
    data("points", [[size, of.estimators.get(f"points/svd-knn/{size}", {}).get("p50_us")] for size in (1000, 10000, 100000, 1000000)])
    data("sensors", [[each["sensors"], 100 * each["cpu"], each["p50_us"], each["p99_us"]] for each in of.of("sensors")])
    data("clients", [[clients] + [of.one("queries", server=server, clients=clients, subscribers=0).get("per_s") for server in ("slipd", "redis")]
                     for clients in (1, 10, 100)])
    for name in ("taxels", "points", "sensors", "clients"):
        subprocess.run([gnuplot, "-e", f"data = '{folder / (name + '.dat')}'; picture = '{out / (name + '.svg')}'; which = '{name}'",
                        str(HERE / "growth.gp")], check=True)
    return True


def write(results, docs, folder):
    of = Results(results)
    grown, paper = estimator_text(of)
    drawn = plots(of, docs, folder)

    def picture(name, what):
        return f"![{what}](performance/{name}.svg)\n" if drawn else ""
    peer = next(iter(of.peer.values()), None)
    ours, theirs = of.training, of.trained_by_peer
    trained = [["slipd, data + SVD + tree", number(ours["training"]["seconds"]), number(ours["training"]["svd_s"]),
                number(ours["training"]["highest_mb"], 0)],
               ["slipd without noise, folded to an eighth (exact only so)", number(ours["folded"]["seconds"]), number(ours["folded"]["svd_s"]),
                number(ours["folded"]["highest_mb"], 0)]]
    if "training" in theirs:
        t = theirs["training"]
        trained.append([f"scikit-learn, SVD + tree of data that is there ({number(t['data_mb'], 0)} MB of it)", number(t["seconds"]), number(t["svd_s"]), number(t["highest_mb"], 0)])
    decode = [[name.removeprefix("decode/"), int(each["packets"]), int(each["taxels"]), *waits(each)[:3]]
              for name, each in of.paths.items() if name.startswith("decode/")]
    hand = [[label, *waits(of.paths.get(name, {}))] for name, label in
            (("mailbox/across/16", "frame of 16 taxels into another core's hands"), ("mailbox/across/10000", "frame of 10000 taxels, likewise"),
             ("estimate/text", "an estimate as text"))]
    ns = lambda name: number(of.paths.get(name, {}).get("real_time"), 1)  # noqa: E731
    text = f"""# How fast slipd is

Made by `tools/bench`; do not edit. Times in µs unless said otherwise, of one frame, one thread; p50, p99, p99.9 and the
longest of all frames measured.

{machine_text(of)}

## What was wanted

{target_table(of)}
The floor is reading a frame and the basis once, by memcpy, and the exact search.

## A frame's estimate

From the frame to the reading: contact patch and method, p50. Contacts of the paper, 1 % relative noise, each frame another
contact; svd-knn with contacts in the middle, all others up to 2 mm off.

{grown}
{picture("taxels", "time of a frame against taxels")}
{paper}
`all of the chain` adds what happens over time: friction, states, alerts, forecast. Its frames are one simulated grasp's.
{f"scikit-learn {peer['version']} with {peer['blas']}. An empty predict is what its call costs before it has anything to do: that much of its time one by one is its client's." if peer else "scikit-learn (python3-sklearn) was not installed."}

svd-knn on 16 x 16 by the number of points in its model:

{picture("points", "time of a frame against a model's points")}
{table(["points", "p50", "p99", "p99.9", "max"], [[number(size, 0), *waits(of.estimators.get(f"points/svd-knn/{size}", {}))] for size in (1000, 10000, 100000, 1000000)])}
## From a device to a client

The real daemon, a device that copies a frame of 100 x 100 and stamps it when it is complete, and a subscribed client on
the same machine; 1 kHz:

{table(["method", "frames", "skipped", "p50", "p99", "p99.9", "max"], [[each["method"], each["frames"], each["skipped"], *waits(each)] for each in of.of("latency")])}
The device waits for the estimator, and no frame is skipped:

{table(["method", "frames/s", "skipped"], [[each["method"], number(each["frames_per_s"], 0), int(each["skipped"])] for each in of.of("throughput")])}
Sensors of 16 x 16 at 1 kHz each, moments; latency from sample to board:

{picture("sensors", "CPU and latency against sensors")}
{table(["sensors", "CPU, % of a core", "p50", "p99", "skipped"], [[each["sensors"], number(100 * each["cpu"], 1), number(each["p50_us"]), number(each["p99_us"]), each["skipped"]] for each in of.of("sensors")])}
CAN needs a bus, which here only the guest of the real-kernel tests has, and a guest's times say nothing of hardware: what a
bus adds is not on this page.

## Questions on the socket

`gamma` of one sensor, and GET of a value of the same size from redis-server on a Unix socket; the same client program for
both, one thread for all its connections, each of which asks again when it has its answer. Server and clients share the cores.
Both servers in turn, five times; the run with the median of queries is shown.

{picture("clients", "queries a second against clients")}
{table(["server", "clients", "subscribers", "queries/s", "p50", "p99", "p99.9", "notifications/s"], list(client_rows(of)))}
{"".join(f"{each['skipped']}." for each in of.of("queries") if "skipped" in each)}
## Between them

Decoding one scan, packets as they come from the bus (framing of byte streams is not in it; a clock reading of 30 ns is):

{table(["profile", "packets", "taxels", "p50", "p99", "p99.9"], decode)}
{table(["hand-over", "p50", "p99", "p99.9", "max"], hand)}
Both sides of the mailbox in one thread take {ns("mailbox/alone/10000")} ns, an estimate onto the board and off it {ns("board/latest")} ns.

## Training

The paper's 10000 taxels x 16000 columns with its noise (4 %), rank 8, seconds, two threads each:

{table(["", "all", "data and SVD", "memory, MB"], trained)}
## Starting, memory, idling

From the start of the program to the first estimate in a client's hands, the model on disk, ms:

{table(["method", "taxels", "p50", "longest"], [[each["method"], f"{each['side']} x {each['side']}", number(each["p50_us"] / 1e3), number(each["max_us"] / 1e3)] for each in of.of("startup")])}
Resident memory, MB; `own` is not shared with files:

{table(["method", "taxels", "locking", "resident", "own"], [[each["method"], f"{each['side']} x {each['side']}", "yes" if each["locking"] else "no", number(each["resident_mb"]), number(each["own_mb"])] for each in of.of("memory")])}
CPU at 1 kHz without contact: {"; ".join(f"{each['side']} x {each['side']}: {number(100 * each['cpu'], 1)} % of a core" for each in of.of("idle"))}.
"""
    (docs / "performance.md").write_text(text)
