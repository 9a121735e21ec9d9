"""What recordings of pillars show of the sensor itself: the values of the simulated preset `pillars` (docs/simulation.md)."""
import math
import statistics

from . import recordings as rec

UNLOADED_ROWS = 100
STEADY_ROWS = 25       # half of the moving mean that shaking is the difference from


def correlation(a, b):
    mean_a, mean_b = statistics.fmean(a), statistics.fmean(b)
    size = math.sqrt(sum((v - mean_a) ** 2 for v in a) * sum((v - mean_b) ** 2 for v in b))
    return sum((v - mean_a) * (w - mean_b) for v, w in zip(a, b)) / size if size else math.nan


def of_grasp(file):
    recording = rec.read(file, 500)
    times, count = recording.times, len(recording.z[0])
    step = (times[-1] - times[0]) / (len(times) - 1)

    def base(axis):
        return [statistics.fmean(row[k] for row in axis[:UNLOADED_ROWS]) for k in range(count)]
    zero = [base(axis) for axis in (recording.x, recording.y, recording.z)]
    noise = [[row[k] - zero[2][k] for row in recording.z[:UNLOADED_ROWS]] for k in range(count)]
    normal = [sum(row) - sum(zero[2]) for row in recording.z]
    median = statistics.median(p for p in normal if p > 0.1 * max(normal))
    held = [i for i, p in enumerate(normal) if p > 0.3 * median]
    middle = held[len(held) // 3:2 * len(held) // 3]
    hold = [normal[i] for i in middle]
    means = [[statistics.fmean(axis[i][k] for i in middle) - off[k] for k in range(count)]
             for axis, off in zip((recording.x, recording.y, recording.z), zero)]
    p = statistics.fmean(hold)
    steady = [statistics.fmean(hold[i - STEADY_ROWS:i + STEADY_ROWS + 1]) for i in range(STEADY_ROWS, len(hold) - STEADY_ROWS, 5)]
    shaking = [hold[i] - mean for i, mean in zip(range(STEADY_ROWS, len(hold) - STEADY_ROWS, 5), steady)]
    peak = normal.index(max(normal))
    level = p + (normal[peak] - p) / math.e
    relaxed = next((times[i] - times[peak] for i in range(peak, len(normal)) if normal[i] < level), math.nan)
    lag = statistics.fmean(correlation(w[:-1], w[1:]) for w in noise)
    return {"noise of a pillar, N": statistics.fmean(statistics.pstdev(w) for w in noise),
            "correlation time of the noise, s": -step / math.log(lag) if 0 < lag < 1 else math.nan,
            "correlation of two pillars": statistics.fmean(correlation(noise[i], noise[j]) for i in range(count) for j in range(i)),
            "closing time, s": times[peak] - times[held[0]],
            "peak of P over its median": max(normal) / median,
            "time of relaxation, s": relaxed,
            "sum of shears over P": sum(math.hypot(x, y) for x, y in zip(means[0], means[1])) / p,
            "resultant over P": math.hypot(sum(means[0]), sum(means[1])) / p,
            "shaking, share of P": statistics.pstdev(shaking) / p,
            "pillars below zero": sum(v < 0 for v in means[2])}


def measure(folder):
    """Prints 10 %, 50 % and 90 % of every second recording of a grasp that nobody pulls at."""
    grasps = [of_grasp(file) for file in sorted(folder.glob("grasp_release*.csv"))[::2]]
    print(f"pillars, {len(grasps)} recordings: 10 %, 50 %, 90 %")
    for name in grasps[0]:
        values = sorted(v for v in (grasp[name] for grasp in grasps) if not math.isnan(v))
        print(f"  {name}: " + ", ".join(f"{values[int(share * (len(values) - 1))]:.4g}" for share in (0.1, 0.5, 0.9)))
