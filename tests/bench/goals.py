"""The goals of tools/bench and how they are judged.

A goal is a ratio: what slipd takes to what a baseline or a peer takes, both measured in the same run, so that it says the same of
slipd on a fast and on a slow machine. Times by themselves are shown and never judged. Sizes (memory) are judged as they are.
"""
import dataclasses

from measured import METHODS, total

WHY = {
    "svd-knn": "where the contact is, and whether its load has only risen, is found out before anything is projected, in some ten passes over its disc",
    "registered": "a plane through the neighbours' margins on top of the search",
    "moments": "the frame is read for its noise, its place twice or more, its forces, its moments and its rings, each needing the one before",
    "fit": "each step evaluates the model and its slopes on every taxel of the disc",
    "latency": "acquire wakes estimate, estimate wakes io, io wakes the client, and each also keeps its accounts",
    "throughput": "two threads hand each frame over, and the device's own copy of it is one more pass over its memory",
    "queries": "slipd waits twice where Redis waits once, in Asio's set and in that of its clients (the table of system calls), which counts for few clients only; "
               "it takes JSON apart and answers what is true now; and the sensor at 1 kHz goes on meanwhile, on the cores that slipd's clients share",
    "shared read": "a whole record is copied under a version that is read before and after, and the clock is read",
    "shared delivery": "acquire wakes estimate, and estimate wakes the reader: two wakes of threads that slept for most of a millisecond, where the baseline's are "
                       "woken at once again, and the estimate between them",
    "shared readers": "readers take the slots' cache lines away, which slipd's thread has to fetch again",
    "push": "a frame is copied once more, from the program's memory to that shared with slipd, and one thread more has to be woken",
    "training": "it goes over the columns until the vectors stand, five times",
    "startup": "the device's drivers are mapped, the model read and its tree built; auto tries its methods on 48 contacts first",
    "memory": "most of it is code that several processes share",
    "idle": "every frame is looked at for a contact",
}


@dataclasses.dataclass(frozen=True)
class Goal:
    what: str  # what slipd does
    ours: float | None  # what it takes, in `unit`; None: not measured
    unit: str
    against: str  # the baseline or the peer
    base: float | None  # what that takes, in `unit`; None: not measured
    limit: float  # of ours / base
    why: str  # what makes it miss, where it does
    more: bool = False  # whether ours / base is to be at least, not at most, the limit
    peer: str | None = None  # the program behind `against`, if it is one that can be left out

    @property
    def ratio(self):
        return self.ours / self.base if self.ours is not None and self.base else None


def size(what, ours, limit, unit, why):
    """A goal that is no ratio: a size is the same on a fast and on a slow machine."""
    return Goal(what, ours, unit, "", 1, limit, why)


def judge(goal, refused=()):
    """met, missed by how much, or why nothing can be said. refused: the peers that are left out."""
    if goal.peer in refused:
        return f"not judged: {goal.peer} is left out"
    if goal.ratio is None:
        return "not measured"
    if goal.ratio >= goal.limit if goal.more else goal.ratio <= goal.limit:
        return "met"
    off = goal.limit / goal.ratio if goal.more else goal.ratio / goal.limit
    return f"missed by {100 * (off - 1):.0f} %"


SKLEARN, REDIS = "scikit-learn", "Redis"


def estimator_goals(of):
    alone, batched = (of.peer.get(way, {}).get("p50_us") for way in ("one by one", "batched"))
    copied, projected = of.floor_us("memcpy", "search"), of.floor_us("gemv", "search")
    for name in ("svd-knn", "registered"):
        ours, why = of.method(name, 100).get("p50_us"), WHY[name]
        yield Goal(f"{name}, 100 x 100", ours, "µs", "frame and basis copied, exact search", copied, 2, why)
        yield Goal(f"{name}, 100 x 100", ours, "µs", "frame projected, exact search", projected, 2, why)
        yield Goal(f"{name}, 100 x 100", ours, "µs", "scikit-learn one by one", alone, 0.1, why, peer=SKLEARN)
        yield Goal(f"{name}, 100 x 100", ours, "µs", "scikit-learn batched", batched, 1, why, peer=SKLEARN)
    yield Goal("moments, 100 x 100", of.method("moments", 100).get("p50_us"), "µs", "frame copied", of.floor_us("frame/100"), 5,
               WHY["moments"])
    for side, limit in ((100, 3), (16, 10)):
        yield Goal(f"fit, {side} x {side}", of.method("fit", side).get("p50_us"), "µs", "one least-squares step",
                   of.floor_us(f"step/{side}"), limit, WHY["fit"])


def percent(share):
    return None if share is None else 100 * share


def pipeline_goals(of):
    way, hand = of.one("floor", name="frame to client", method="registered"), of.one("latency", method="registered")
    for quantile, limit in (("p50_us", 1.25), ("p99_us", 2)):
        yield Goal(f"frame complete to client at 1 kHz, registered, {quantile[:3]}", hand.get(quantile), "µs",
                   "the same threads without work, and the estimate", total(way.get(quantile), of.chain("registered", 100).get(quantile)),
                   limit, WHY["latency"])
    handed = of.one("floor", name="frame there and back").get("p50_us")
    for name in METHODS[:3]:
        rate = of.one("throughput", method=name).get("frames_per_s")
        yield Goal(f"a frame of 100 x 100 through the pipeline, {name}", 1e6 / rate if rate else None, "µs",
                   "frame handed there and back, and the estimate", total(handed, of.chain(name, 100).get("p50_us")), 2, WHY["throughput"])
    for side in (4, 100):
        cpu, least = of.one("idle", side=side).get("cpu"), of.one("floor", name="two threads at 1 kHz", side=side).get("cpu")
        yield Goal(f"CPU without contact, {side} x {side} at 1 kHz", cpu and 100 * cpu, "% of a core", "two threads that wake and sleep",
                   least and 100 * least, 2, WHY["idle"])


def socket_goals(of):
    yield Goal("gamma, 1 client, p50", of.queries("slipd", 1).get("p50_us"), "µs", "round trip on a Unix socket",
               of.queries("echo", 1).get("p50_us"), 2, WHY["queries"])
    for clients in (1, 10, 100):
        ours, redis = of.queries("slipd", clients), of.queries("redis", clients)
        yield Goal(f"gamma, {clients} client{'s' * (clients > 1)}, queries", ours.get("per_s"), "a second", "Redis GET", redis.get("per_s"), 1,
                   WHY["queries"], more=True, peer=REDIS)
        yield Goal(f"gamma, {clients} client{'s' * (clients > 1)}, p99", ours.get("p99_us"), "µs", "Redis GET", redis.get("p99_us"), 1,
                   WHY["queries"], peer=REDIS)


def shared_goals(of):
    reads, ours, redis = of.one("shared reads"), of.one("shared rate", server="slipd"), of.one("shared rate", server="redis")
    yield Goal("latest record of the shared memory", reads.get("record_ns"), "ns", "its bytes copied", reads.get("memcpy_ns"), 5,
               WHY["shared read"])
    yield Goal("latest estimate of the shared memory, reads", ours.get("per_s"), "a second", "Redis GET, 1 client", redis.get("per_s"), 100,
               WHY["shared read"], more=True, peer=REDIS)
    for quantile in ("p50_us", "p99_us"):
        way = of.one("shared delivery", side=100)
        yield Goal(f"frame complete to waiting reader at 1 kHz, moments, 100 x 100, {quantile[:3]}", way.get("reader", {}).get(quantile), "µs",
                   "subscriber of the socket", way.get("subscriber", {}).get(quantile), 0.5, WHY["shared delivery"])
    least = of.one("shared delivery", side=4)
    yield Goal("frame complete to waiting reader at 1 kHz, moments, 4 x 4, p50", least.get("reader", {}).get("p50_us"), "µs", "futex wake",
               least.get("futex wake", {}).get("p50_us"), 3, WHY["shared delivery"])
    crowd = of.one("shared readers", looking=100)
    cpu, alone = crowd.get("cpu"), crowd.get("cpu_alone")
    spent = None if cpu is None or alone is None else 100 * (cpu - alone)
    yield Goal("CPU of slipd for 100 readers that look 100 times a second", spent, "% of a core", "a core", 100, 0.01, WHY["shared readers"])


def push_goals(of):
    for side in (4, 100):
        way = of.one("push", side=side)
        yield Goal(f"frame pushed by a program to waiting reader at 1 kHz, moments, {side} x {side}, p99", way.get("program", {}).get("p99_us"), "µs",
                   "the same of a device in the daemon", way.get("device", {}).get("p99_us"), 1.5, WHY["push"])
    cpu = of.one("push", side=100).get("program", {}).get("cpu")
    yield Goal("CPU of slipd for frames of a program at 1 kHz, moments, 100 x 100", cpu and 100 * cpu, "% of a core", "a core", 100, 0.1, WHY["push"])


def training_goals(of):
    ours, theirs = of.training.get("training", {}), of.trained_by_peer.get("training", {})
    yield Goal("SVD and index of 10000 x 16000, data in memory", of.training.get("held", {}).get("seconds"), "s", "scikit-learn's, data in memory",
               theirs.get("seconds"), 1 / 3, WHY["training"], peer=SKLEARN)
    yield Goal("its memory", ours.get("highest_mb"), "MB", "scikit-learn's", theirs.get("highest_mb"), 1 / 3, WHY["training"], peer=SKLEARN)
    yield dataclasses.replace(size("its singular values, relative to a full SVD's", of.singular_error(), 1e-4, "", WHY["training"]),
                              peer=SKLEARN)


def program_goals(of):
    redis = of.one("startup", method="redis").get("p50_us")
    for name in ("moments", "svd-knn", "registered", "auto"):
        start = of.one("startup", method=name)
        if start:
            yield Goal(f"start-up to first estimate, {name}, {start['side']} x {start['side']}", start["p50_us"] / 1e3, "ms",
                       "Redis, start-up to first answer", redis and redis / 1e3, 10, WHY["startup"], peer=REDIS)
    for locking in (False, True):
        for method, side, limit in (("moments", 4, 15), ("svd-knn", 100, 30), ("registered", 100, 30)):
            yield size(f"resident memory, {method}, {side} x {side}, {'locked' if locking else 'not locked'}",
                       of.one("memory", method=method, side=side, locking=locking).get("resident_mb"), limit, "MB", WHY["memory"])


def goals(of):
    for group in (estimator_goals, pipeline_goals, socket_goals, shared_goals, push_goals, training_goals, program_goals):
        yield from group(of)
