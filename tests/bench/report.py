"""What tools/bench has measured, as docs/performance.md and its plots. Every figure on the page comes from the results."""
from goals import goals, judge
from measured import METHODS, Measured
from pictures import draw


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


def machine_text(of):
    m = of.machine
    level = ", ".join(f"{name} {size}" for name, size in m["caches"].items())
    return (f"{m['processor']}{' (a virtual machine)' if m['virtual'] else ''}, {m['cores']} cores, {level}, {m['memory_mb']} MB; "
            f"instructions {', '.join(m['vectors']) or 'of the baseline'}; kernel {m['kernel']}; {m['compiler']}; build type Release "
            f"for the baseline instruction set; no real-time privileges asked for; load average before {m['load_before']:.2f}; "
            f"{m['date']}, commit {m['commit']}. All in one run of {of.minutes:.1f} minutes."
            + (" **Others used the machine when the run began: its times are longer than they would be.**" if m["load_before"] > 1 else ""))


def goal_table(of):
    rows = []
    for goal in goals(of):
        tiny = 4 if goal.limit < 0.01 else None
        target = f"{'≥' if goal.more else '≤'} {number(goal.limit, tiny)}{'' if goal.against else f' {goal.unit}'}".strip()
        ours = "–" if goal.ours is None else f"{number(goal.ours, 6 if tiny else None)} {goal.unit}".strip()
        rows.append([goal.what, ours,
                     f"{goal.against}: {number(goal.base)}" if goal.against else "", target,
                     number(goal.ratio, 6 if tiny else None) if goal.against else "", judge(goal, of.refused)])
    missed = [goal for goal in goals(of) if judge(goal, of.refused).startswith("missed")]
    reasons = {}
    for goal in missed:
        reasons.setdefault(goal.why, []).append(goal.what)
    why = "\n".join(f"* {'; '.join(dict.fromkeys(what))}: {reason}." for reason, what in reasons.items())
    return table(["", "measured", "against", "target", "ratio", ""], rows) + (f"\n\nWhy targets are missed:\n\n{why}\n" if missed else "")


def refused_text(of):
    if not of.refused:
        return ""
    said = "\n".join(f"* {each['peer']}: {each['why']}; {each['remedy']}." for each in of.refused.values())
    return f"**Peers that are left out**, because they are not there or not at their best:\n\n{said}\n\n"


GOALS = """A goal is a ratio to a baseline or to a peer, both measured in the same run as slipd, so that it says the same on a fast and on a
slow machine. Times and rates by themselves are shown and never judged. A peer that is not installed, or not at its best (numpy
without OpenBLAS, a BLAS on fewer threads than there are cores), is left out, and its goals are not judged. Memory is a size: it is
judged in MB. The ratios to baselines leave svd-knn, moments, fit and the way to the client about as much room as limits of 10, 6, 300
and 60 µs left on a quiet machine of 2.6 GHz with AVX-512.

| against | what that is |
|---|---|
| frame and basis copied, exact search | memcpy of a frame of 100 x 100 (from L3) and of the basis (from L2), and FLANN's exact search |
| frame projected, exact search | the basis times a full frame, by Eigen, and the same search |
| frame copied | memcpy of a frame of 100 x 100, from L3 |
| one least-squares step | six unknowns over two residuals of each taxel of the whole frame: the normal equations and their solution, by Eigen in double |
| the same threads without work, and the estimate | `frame to client`: a thread that copies a frame at 1 kHz wakes by a futex one that copies it again, which wakes by an eventfd one that sends 300 bytes on a Unix socket to one that waits for them; and the method's time, all of the chain. p99: the sum of both p99 |
| frame handed there and back, and the estimate | `frame there and back`: a thread copies a frame and wakes by a futex one that copies it again and wakes the first; and the method's time, all of the chain |
| two threads that wake and sleep | CPU time of a thread that the clock wakes at 1 kHz and of one that it wakes by a futex each time |
| round trip on a Unix socket | the same client, and a server of one thread that answers each request with as many bytes as slipd |
| Redis GET | redis-server on a Unix socket, a value of the same size, the same client |
| Redis, start-up to first answer | from the start of redis-server until it has answered a GET |
| scikit-learn | KNeighborsRegressor and randomized_svd on OpenBLAS with all cores (estimating: or with one thread, if that is faster), on the same frames, points and columns |
"""


def estimator_text(of):
    sides = [4, 8, 16, 32, 64, 100, 160, 256]
    rows = [[f"{side} x {side}"] + [number(of.method(name, side).get("p50_us")) for name in METHODS] for side in sides]
    grown = table(["taxels", *METHODS], rows)
    rows = [[name, *waits(of.method(name, 100))] for name in METHODS]
    rows += [[f"{name}, all of the chain", *waits(of.chain(name, 100))] for name in METHODS]
    rows += [[f"baseline: {what}", *waits(of.estimators.get(f"floor/{name}", {}))] for name, what in
             (("frame/100", "frame copied, from L3"), ("memcpy", "frame (from L3) and basis (from L2), copied"),
              ("gemv", "basis times a full frame, Eigen, from L2"), ("search", "FLANN's exact search"),
              ("step/100", "one least-squares step over the whole frame, Eigen"))]
    for way, each in of.peer.items():
        parts = each.get("parts")
        more = f" ({', '.join(f'{part} {number(us)}' for part, us in parts.items())})" if parts else ""
        rows.append([f"scikit-learn, {way}{more}", *waits(each)])
    return grown, table(["100 x 100", "p50", "p99", "p99.9", "max"], rows)


def estimators_section(of, picture):
    grown, paper = estimator_text(of)
    peer = next(iter(of.peer.values()), None)
    points = [[number(size, 0), *waits(of.estimators.get(f"points/svd-knn/{size}", {}))] for size in (1000, 10000, 100000, 1000000)]
    return f"""## A frame's estimate

From the frame to the estimate: contact patch and method, p50. Contacts of the paper, 1 % relative noise, each frame another
contact; svd-knn with contacts in the middle, all others up to 2 mm off.

{grown}
{picture("taxels", "time of a frame against taxels")}
{paper}
`all of the chain` adds friction over time, states, alerts and forecast. **Its rows are not comparable with the rows above**: its frames are those of
one simulated grasp, pressed, loaded, unloaded and eased for ever, where most frames need no new fit.
{f"scikit-learn {peer['version']} with {peer['blas']}. An empty predict is the overhead of a call, which is part of its time one by one." if peer else "scikit-learn is left out."}

svd-knn on 16 x 16 by the number of points in its model:

{picture("points", "time of a frame against a model's points")}
{table(["points", "p50", "p99", "p99.9", "max"], points)}"""


def floor_rows(of):
    for each in of.of("floor"):
        if "p50_us" in each:
            yield [each["name"] + (f", beside {each['method']}" if "method" in each else ""), *waits(each)]


def pipeline_section(of, picture):
    latency = [[each["method"], each["frames"], each["skipped"], *waits(each)] for each in of.of("latency")]
    rates = [[each["method"], number(each["frames_per_s"], 0), int(each["skipped"])] for each in of.of("throughput")]
    sensors = [[each["sensors"], number(100 * each["cpu"], 1), number(each["p50_us"]), number(each["p99_us"]), each["skipped"]]
               for each in of.of("sensors")]
    return f"""## From a device to a client

The real daemon, a device that copies a frame of 100 x 100 and stamps it when it is complete, and a subscribed client on
the same machine; 1 kHz:

{table(["method", "frames", "skipped", "p50", "p99", "p99.9", "max"], latency)}
The baselines, with nothing to do in them; `frame to client` at 1 kHz as well, measured before each method:

{table(["baseline", "p50", "p99", "p99.9", "max"], list(floor_rows(of)))}
The device waits for the estimator, and no frame is skipped:

{table(["method", "frames/s", "skipped"], rates)}
Sensors of 16 x 16 at 1 kHz each, moments; latency from sample to snapshot:

{picture("sensors", "CPU and latency against sensors")}
{table(["sensors", "CPU, % of a core", "p50", "p99", "skipped"], sensors)}
Up to 128 sensors, on one bus or on as many devices, and where the time goes: [growth.md](growth.md).

CAN needs a bus, which here only the guest of the real-kernel tests has, and a guest's times say nothing of hardware: what a
bus adds is not on this page.
"""


def client_rows(of):
    for each in of.of("queries"):
        heard = number(each.get("heard_per_s"), 0) if each.get("heard_per_s") else ""
        yield [each["server"], each["clients"], each["subscribers"], number(each["per_s"], 0), *waits(each)[:3], heard]


def calls_section(of):
    rows = [[each["server"], each["clients"], *(number(each[kind]) for kind in ("read", "write", "wait", "control"))] for each in of.of("calls")]
    if not rows:
        return ""
    return f"""
What each asks of the kernel for an answer, counted by perf:

{table(["server", "clients", "read", "write", "epoll_wait", "epoll_ctl"], rows)}"""


def socket_section(of, picture):
    return f"""## Questions on the socket

`gamma` of one sensor, GET of a value of the same size from redis-server on a Unix socket, and a server that does nothing but
answer as many bytes (`echo`); the same client program for all, one thread for all its connections, each of which asks again
when it has its answer. Server and clients share the cores. All servers in turn, five times; the run with the median of queries
is shown.

{picture("clients", "queries a second against clients")}
{table(["server", "clients", "subscribers", "queries/s", "p50", "p99", "p99.9", "notifications/s"], list(client_rows(of)))}{calls_section(of)}"""


def shared_section(of):
    reads = of.one("shared reads")
    costs = [[what, number(reads.get(key))] for what, key in
             (("a record's bytes copied", "memcpy_ns"), ("the latest record", "record_ns"), ("slipd_latest()", "latest_ns"),
              ("slipd writes a record", "write_ns"), ("the same, and wakes one who does not wait", "write_and_wake_nobody_ns"))]
    rates = [[each["server"], number(each["per_s"], 0)] for each in of.of("shared rate")]
    hands = [[f"{each['side']} x {each['side']}", who, *waits(each[who])] for each in of.of("shared delivery")
             for who in ("reader", "subscriber", "futex wake")]
    crowds = [[each["looking"], each["waiting"], number(100 * each["cpu_alone"]), number(100 * each["cpu"])] for each in of.of("shared readers")]
    return f"""## Shared memory

Each copied record has {number(reads.get("bytes"), 0)} bytes; ns, the least of several runs:

{table(["", "ns"], costs)}
Reads a second of one reader of the latest estimate (`slipd_latest`), and GETs of one client of redis-server for a value of the size of a
record, in turn:

{table(["server", "reads/s"], rates)}
From a complete frame at 1 kHz until a reader that waits (`slipd_wait`) has its estimate, beside a subscriber of the socket, in turn, and
what one thread takes to wake another; moments:

{table(["taxels", "", "p50", "p99", "p99.9", "max"], hands)}
What readers cost slipd, % of a core, with and without them in turn, 100 x 100 at 1 kHz. One that looks reads a hundred times a second; one
that waits is woken for each estimate:

{table(["readers that look", "that wait", "slipd alone", "beside them"], crowds)}"""


def push_section(of):
    rows = [[f"{each['side']} x {each['side']}", who, *waits(each[who]), number(100 * each[who]["cpu"]), each[who]["received"], each[who]["lost"] + each[who]["corrupt"]]
            for each in of.of("push") for who in ("device", "program")]
    return f"""## Frames from a program

From the sample of a frame that a program pushes (docs/push.md) to the estimate of a reader that waits (`slipd_wait`), beside a device in the daemon
with the same frames, in turn; 1 kHz, moments; CPU of slipd in % of a core; frames of the last turn that were received, and that were lost or corrupt:

{table(["taxels", "", "p50", "p99", "p99.9", "max", "CPU", "received", "lost"], rows)}"""


def between_section(of):
    decode = [[name.removeprefix("decode/"), int(each["packets"]), int(each["taxels"]), *waits(each)[:3]]
              for name, each in of.paths.items() if name.startswith("decode/")]
    hand = [[label, *waits(of.paths.get(name, {}))] for name, label in
            (("mailbox/across/16", "frame of 16 taxels into another core's hands"), ("mailbox/across/10000", "frame of 10000 taxels, likewise"),
             ("estimate/text", "an estimate as text"))]
    mailbox, board = (number(of.paths.get(name, {}).get("real_time"), 1) for name in ("mailbox/alone/10000", "board/latest"))
    return f"""## Between them

Decoding one scan, packets as they come from the bus (framing of byte streams is not in it; a clock reading of 30 ns is):

{table(["profile", "packets", "taxels", "p50", "p99", "p99.9"], decode)}
{table(["hand-over", "p50", "p99", "p99.9", "max"], hand)}
Both sides of the mailbox in one thread take {mailbox} ns, an estimate into the snapshot and out of it {board} ns.
"""


def training_section(of):
    ours, theirs = of.training, of.trained_by_peer.get("training")
    rows = [[what, number(ours[part]["seconds"]), number(ours[part]["svd_s"]), number(ours[part]["highest_mb"], 0)] for part, what in
            (("training", "slipd, data + SVD + tree"), ("held", "slipd, SVD + tree of data that is there"), ("folded", "slipd without noise, folded to an eighth (exact only so)"))
            if part in ours]
    if theirs:
        rows.append([f"scikit-learn, SVD + tree of data that is there ({number(theirs['data_mb'], 0)} MB of it)", number(theirs["seconds"]),
                     number(theirs["svd_s"]), number(theirs["highest_mb"], 0)])
    return f"""## Training

The paper's 10000 taxels x 16000 columns with its noise (4 %), rank 8, seconds; slipd on up to four cores, its peer on all:

{table(["", "all", "data and SVD", "memory, MB"], rows)}"""


def program_section(of):
    start = [[each["method"], f"{each['side']} x {each['side']}" if "side" in each else "", number(each["p50_us"] / 1e3), number(each["max_us"] / 1e3)]
             for each in of.of("startup")]
    memory = [[each["method"], f"{each['side']} x {each['side']}", "yes" if each["locking"] else "no", number(each["resident_mb"]),
               number(each["own_mb"])] for each in of.of("memory")]
    idle = "; ".join(f"{each['side']} x {each['side']}: {number(100 * each['cpu'], 1)} % of a core" for each in of.of("idle"))
    floor = of.one("floor", name="two threads at 1 kHz").get("cpu")
    return f"""## Starting, memory, idling

From the start of the program to the first estimate in a client's hands, the model on disk, ms; `redis`: to its first answer:

{table(["method", "taxels", "p50", "longest"], start)}
Resident memory, MB; `own` is not shared with files:

{table(["method", "taxels", "locking", "resident", "own"], memory)}
CPU at 1 kHz without contact: {idle}; two threads that only wake and sleep: {number(floor and 100 * floor, 1)} % of a core.
"""


def page(of, drawn):
    def picture(name, what):
        return f"![{what}](performance/{name}.svg)\n" if drawn else ""
    head = f"""# How fast slipd is

Made by `tools/bench`; do not edit. Times in µs unless said otherwise, of one frame, one thread; p50, p99, p99.9 and the
longest of all frames measured.

{machine_text(of)}

## Targets

{goal_table(of)}
{refused_text(of)}## How the goals are defined

{GOALS}"""
    sections = [head, estimators_section(of, picture), pipeline_section(of, picture), socket_section(of, picture), shared_section(of), push_section(of), between_section(of),
                training_section(of), program_section(of)]
    return "\n".join(section.rstrip() + "\n" for section in sections)


def write(results, docs, folder):
    of = Measured(results)
    (docs / "performance.md").write_text(page(of, draw(of, docs, folder)))
