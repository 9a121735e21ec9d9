"""What one run of tools/bench has measured, by name. What was not measured is None or empty, never an error."""

METHODS = ["moments", "svd-knn", "registered", "fit"]


def total(*values):
    """Of all of them, or None if one is not there."""
    return None if any(value is None for value in values) else sum(values)


class Measured:
    def __init__(self, results):
        self.minutes = results["minutes"]
        self.machine = results["machine"]
        self.estimators = results["estimators"]["ours"]
        self.paths = results["paths"]
        self.training = {each["part"]: each for each in results["training"]["ours"]}
        self.daemon = [each for each in results["daemon"] if each["part"] != "refused"]
        peers = results["estimators"]["peer"] + results["training"]["peer"]
        self.peer = {each["way"]: each for each in peers if each["part"] == "estimate"}
        self.trained_by_peer = {each["part"]: each for each in peers if each["part"] in ("training", "exact")}
        # Each peer that is left out, once: why, and what to do about it.
        self.refused = {each["peer"]: each for each in peers + results["daemon"] if each["part"] == "refused"}

    def method(self, name, side):
        return self.estimators.get(f"method/{name}/{side}", {})

    def chain(self, name, side):
        return self.estimators.get(f"chain/{name}/{side}", {})

    def floor_us(self, *names):
        return total(*(self.estimators.get(f"floor/{name}", {}).get("p50_us") for name in names))

    def of(self, part, **like):
        return [each for each in self.daemon
                if each["part"] == part and all(each.get(key) == value for key, value in like.items())]

    def one(self, part, **like):
        found = self.of(part, **like)
        return found[0] if found else {}

    def queries(self, server, clients):
        return self.one("queries", server=server, clients=clients, subscribers=0)

    def singular_error(self):
        ours, exact = self.training.get("training"), self.trained_by_peer.get("exact")
        if not ours or not exact:
            return None
        return max(abs(a - b) / b for a, b in zip(ours["singular_values"], exact["singular_values"]))
