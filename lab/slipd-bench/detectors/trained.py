"""trained.py train FOLDER MODEL | run MODEL: a logistic regression on the scores of plain.py, their past second's greatest, and P's course.

FOLDER has N.frames and N.labels of each recording that it may learn from."""
import json
import sys
from pathlib import Path

import numpy as np
from frames import Frames, past_mean, write
from plain import SCORES, score, size_of

REMEMBERED_S = 1.0
STRENGTH = 1.0        # of the penalty on weights, which are of standardised features
STEPS = 30            # of Newton's method


def recent_greatest(values, rows):
    padded = np.concatenate([np.full(rows, -np.inf), values])
    return np.lib.stride_tricks.sliding_window_view(padded, rows + 1).max(axis=1)


def features(frames):
    columns = []
    for name in SCORES:
        values = np.nan_to_num(score(frames, name))
        columns += [values, recent_greatest(values, frames.rows_in(REMEMBERED_S))]
    load = sum(np.nan_to_num(size_of(frames, values)) for values in frames.values.values())
    mean = past_mean(load, frames.rows_in(REMEMBERED_S))
    columns.append((load - mean) / np.maximum(mean, 1e-9 + frames.least_normal))
    return np.arcsinh(10 * np.stack(columns, axis=1))


def fit(rows, labels):
    mean, spread = rows.mean(axis=0), rows.std(axis=0) + 1e-9
    x = np.c_[(rows - mean) / spread, np.ones(len(rows))]
    even = np.where(labels, 0.5 / max(1, labels.sum()), 0.5 / max(1, (~labels).sum())) * len(labels)
    weights = np.zeros(x.shape[1])
    for _ in range(STEPS):
        p = 1 / (1 + np.exp(-np.clip(x @ weights, -30, 30)))
        slope = x.T @ (even * (p - labels)) + STRENGTH * weights
        weights -= np.linalg.solve((x * (even * p * (1 - p))[:, None]).T @ x + STRENGTH * np.eye(len(weights)), slope)
    return {"mean": mean.tolist(), "spread": spread.tolist(), "weights": weights.tolist()}


def train(folder, model):
    rows, labels = [], []
    for file in sorted(folder.glob("*.frames")):
        known = np.array(json.loads(file.with_suffix(".labels").read_text()), float)
        with open(file) as lines:
            found = features(Frames(lines))
        rows.append(found[~np.isnan(known)])
        labels.append(known[~np.isnan(known)] == 1)
    model.write_text(json.dumps(fit(np.concatenate(rows), np.concatenate(labels))))


def run(model):
    frames, m = Frames(iter(sys.stdin)), json.loads(model.read_text())
    x = np.c_[(features(frames) - m["mean"]) / np.array(m["spread"]), np.ones(len(frames.times))]
    probability = 1 / (1 + np.exp(-np.clip(x @ np.array(m["weights"]), -30, 30)))
    write(frames.times, probability, probability > 0.5)


if __name__ == "__main__":
    if sys.argv[1] == "train":
        train(Path(sys.argv[2]), Path(sys.argv[3]))
    else:
        run(Path(sys.argv[2]))
