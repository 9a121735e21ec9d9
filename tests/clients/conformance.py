"""conformance.py SOCKET: the Python module under conformance_test.py; the same commands and answers as conformance.c."""
import json, math, sys

import slipd

TIMEOUT_S = 1.0
SUBSCRIBE_TIMEOUT_S = 300.0  # on a busy machine


def answer(code, estimate=None):
    known = {} if estimate is None else {
        "name": estimate.name, "state": estimate.state, "alert": estimate.alert, "alert_cause": estimate.alert_cause, "seq": estimate.seq or 0, "dropped": estimate.dropped,
        "simulated": estimate.simulated, "gamma": estimate.gamma, "gamma_low": estimate.gamma_low, "normal_n": estimate.normal_n,
        "shear_n": estimate.shear_n, "age_s": estimate.age_s if math.isfinite(estimate.age_s) else None}
    print(json.dumps({"code": code, "state": "disconnected", "gamma": None, **known}), flush=True)


class Commands:
    def __init__(self, path):
        self.client, self.board = slipd.Client(path), slipd.Board(path, timeout_s=TIMEOUT_S)
        self.estimates = iter(())

    def gamma(self, name, max_age_s, timeout_s):
        self.client.timeout_s = timeout_s
        return "done", self.client.gamma(name, max_age_s)

    def grasp(self, name, max_age_s, timeout_s):
        self.client.timeout_s = timeout_s
        return "done", self.client.grasp(name, max_age_s)

    def latest(self, name, max_age_s):
        estimate = self.board.latest(name, max_age_s)
        return "disconnected" if estimate.at_state == "disconnected" else "done", estimate

    def subscribe(self, name, max_age_s):
        self.client.timeout_s = SUBSCRIBE_TIMEOUT_S
        self.estimates = self.client.estimates(name, max_age_s=max_age_s)
        self.first = next(self.estimates)  # the subscription is made by the first one
        return "done", None

    def next(self):
        estimate, self.first = self.first or next(self.estimates), None
        if estimate.at_state == "disconnected":
            return "disconnected", estimate
        return "done" if estimate.values else "timeout", estimate  # what slipd sent, or what the module adds in silence


def main(path):
    commands = Commands(path)
    for line in sys.stdin:
        verb, *words = line.split()
        try:
            answer(*getattr(commands, verb)(*words[:1], *map(float, words[1:])))
        except slipd.SlipdError:
            answer("refused")
        except TimeoutError:
            answer("timeout")
        except OSError:
            answer("disconnected")


if __name__ == "__main__":
    main(sys.argv[1])
