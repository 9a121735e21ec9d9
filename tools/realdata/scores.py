"""Receiver operating characteristics and lead times."""


def roc(positive, negative):
    """Points (false, true) of all thresholds, from (0, 0) to (1, 1), of statistics that are larger for positives."""
    points = [(0.0, 0.0)]
    for limit in sorted(set(positive) | set(negative), reverse=True):
        points.append((sum(v >= limit for v in negative) / len(negative), sum(v >= limit for v in positive) / len(positive)))
    return points


def area(points):
    """Under the curve; 0.5 is chance."""
    return sum((b[0] - a[0]) * (a[1] + b[1]) / 2 for a, b in zip(points, points[1:]))


def best_balanced(points):
    """The best balanced accuracy of all thresholds, chosen after the labels were seen."""
    return max((1 - false + true) / 2 for false, true in points)


def balanced(found, labels):
    positive = [f for f, l in zip(found, labels) if l]
    negative = [not f for f, l in zip(found, labels) if not l]
    return (sum(positive) / len(positive) + sum(negative) / len(negative)) / 2


def first_above(statistic, times, limit, begin=0.0):
    """When a statistic first exceeds a limit, s; None: never."""
    return next((t for v, t in zip(statistic, times) if v > limit and t >= begin), None)
