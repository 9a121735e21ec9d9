#!/usr/bin/python3
"""peers.py estimate|train FOLDER: what scikit-learn takes for the same, on the files that the benchmarks have left in FOLDER.

estimate: angle, projection and the five nearest neighbours of each frame, one by one and all at once.
train: randomized SVD of the paper's data set and a search tree on its coordinates.
Prints one JSON object a line; a single one, {"part": "refused"}, where scikit-learn is missing or not at its best (peer_check.py).
The libraries may use all cores; estimating is shown with all or with one thread, whichever is faster.
"""
import json
import os
import pathlib
import resource
import sys
import time

from peer_check import blas_refusal, blas_text, missing_refusal

try:
    import numpy as np
    import scipy.sparse.linalg
    import sklearn
    from sklearn.neighbors import KNeighborsRegressor
    from sklearn.utils.extmath import randomized_svd
    from threadpoolctl import threadpool_info, threadpool_limits
    MISSING = None
except ImportError as error:
    MISSING = error.name

RANK = 8


def say(part, **values):
    print(json.dumps({"part": part, "version": sklearn.__version__, "blas": blas_text(threadpool_info()), **values}), flush=True)


def refusal():
    if MISSING:
        return missing_refusal("scikit-learn", f"Python's {MISSING}", "python3-sklearn and libopenblas0-pthread")
    return blas_refusal(threadpool_info(), len(os.sched_getaffinity(0)))


def highest_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def quantiles(times):
    times = np.sort(np.array(times)) * 1e6
    return {f"{name}_us": float(times[int(share * (len(times) - 1))])
            for name, share in (("p50", .5), ("p99", .99), ("p999", .999), ("max", 1))}


def medians_us(parts):
    return {name: float(np.median(spent)) * 1e6 for name, spent in parts.items()}


def angle(frame):
    """Along the resultant, where there is pressure: as slipd's."""
    p, x, y = frame[..., 0, :], frame[..., 1, :], frame[..., 2, :]
    inside = p > np.float32(.1) * p.max(axis=-1, keepdims=True)
    qx, qy = (np.einsum("...i,...i->...", q, inside)[..., None] for q in (x, y))
    size = np.hypot(qx, qy)
    along = x * (qx / size) + y * (qy / size)
    return np.arctan(np.divide(along, p, out=np.zeros_like(p), where=inside))


def one_by_one(frames, across, knn):
    times, parts = [], {"angle": [], "projection": [], "neighbours": []}
    for i in range(1000):
        frame = frames[i % len(frames)]
        t0 = time.perf_counter()
        alpha = angle(frame)
        t1 = time.perf_counter()
        point = across @ alpha
        t2 = time.perf_counter()
        knn.predict(point[None, :])
        t3 = time.perf_counter()
        times.append(t3 - t0)
        for name, spent in zip(parts, (t1 - t0, t2 - t1, t3 - t2)):
            parts[name].append(spent)
    return {"way": "one by one", **quantiles(times), "parts": medians_us(parts)}


def empty_predict(knn, points):
    calls = []
    for i in range(1000):
        t0 = time.perf_counter()
        knn.predict(points[i:i + 1])
        calls.append(time.perf_counter() - t0)
    say("estimate", way="an empty predict", **quantiles(calls))


def batched(frames, basis, knns):
    """Angles of eight at a time: more fall out of the cache and take longer. Neighbours of many more: fewer take longer; by the
    faster of the searches, with one job and with one a core."""
    at_once, many = 8, 20
    angles, projections, searches = [], [], [[] for _ in knns]
    for _ in range(50):
        t0 = time.perf_counter()
        alpha = np.concatenate([angle(frames[i:i + at_once]) for i in range(0, len(frames), at_once)])
        t1 = time.perf_counter()
        found = alpha @ basis
        t2 = time.perf_counter()
        angles.append((t1 - t0) / len(frames))
        projections.append((t2 - t1) / len(frames))
        rows = np.tile(found, (many, 1))
        for knn, spent in zip(knns, searches):
            t3 = time.perf_counter()
            knn.predict(rows)
            spent.append((time.perf_counter() - t3) / len(rows))
    parts = {"angle": angles, "projection": projections, "neighbours": min(searches, key=np.median)}
    return {"way": "batched", "frames": len(frames), **quantiles(np.sum(list(parts.values()), axis=0)), "parts": medians_us(parts)}


def say_faster(measure, *words):
    """With all cores and with one thread: on a busy machine, or for little work, threads that wait for each other are slower."""
    both = [measure(*words)]
    with threadpool_limits(1):
        both.append(measure(*words))
    say("estimate", **min(both, key=lambda each: each["p50_us"]))


def estimate(folder):
    def read(name, *shape):
        return np.fromfile(folder / name, np.float32).reshape(shape)
    basis = read("basis.f32", -1, RANK)
    points = read("points.f32", -1, RANK)
    gamma = read("gamma.f32", -1)
    frames = read("frames.f32", -1, 3, basis.shape[0])
    one_job, all_cores = (KNeighborsRegressor(5, algorithm="kd_tree", weights="distance", n_jobs=jobs).fit(points, gamma)
                          for jobs in (None, -1))
    say_faster(one_by_one, frames, np.ascontiguousarray(basis.T), one_job)
    # What a call costs its client: the same where there is next to nothing to do.
    empty_predict(KNeighborsRegressor(1, algorithm="kd_tree").fit(points[:2], gamma[:2]), points)
    say_faster(batched, frames, basis, [one_job, all_cores])


def train(folder):
    taxels = 10000
    columns = np.fromfile(folder / "columns.f32", np.float32).reshape(-1, taxels).T
    held_mb = highest_mb()
    t0 = time.perf_counter()
    u, s, vt = randomized_svd(columns, RANK, random_state=0)
    svd_s = time.perf_counter() - t0
    KNeighborsRegressor(5, algorithm="kd_tree").fit((s[:, None] * vt).T, np.zeros(columns.shape[1]))
    say("training", seconds=time.perf_counter() - t0, svd_s=svd_s, data_mb=held_mb, highest_mb=highest_mb(),
        singular_values=[float(v) for v in s])
    # The true values, by Lanczos to the end of what single precision holds.
    exact = scipy.sparse.linalg.svds(columns, RANK, tol=1e-6, random_state=0, return_singular_vectors=False)
    say("exact", singular_values=sorted((float(v) for v in exact), reverse=True))


def main(what, folder):
    why_not = refusal()
    if why_not:
        print(json.dumps(why_not))
    else:
        {"estimate": estimate, "train": train}[what](pathlib.Path(folder))


if __name__ == "__main__":
    main(*sys.argv[1:])
