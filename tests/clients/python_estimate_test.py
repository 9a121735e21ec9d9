"""What an estimate of the Python module says as it gets old. The clock is the test's."""
import unittest
from unittest import mock

import slipd

MAX_AGE_S = 0.1
SENT = {"sensor": "left", "seq": 7, "time_ns": None, "state": "ok", "gamma": 0.6, "sigma": 0.01, "class": 4, "gamma_low": 0.5,
        "friction": 0.4, "friction_sigma": 0.02, "normal_n": 2.0, "shear_n": 0.3, "torque_nmm": 0.1, "a_over_r": 0.7,
        "time_to_slip_ms": 30.0, "grip_increase_n": 0.2, "grip_increase_sigma_n": 0.1, "alert": "none", "alert_cause": None,
        "sliding": "none", "sliding_for_ms": 500, "health": "good", "simulated": False, "age_ms": 0.0}
NOT_WHEN_OLD = ("gamma", "gamma_low", "sigma", "grip_increase_n", "time_to_slip_ms", "sliding")


class Clock:
    """In place of the module `time`. `passes_s`: what each look at it takes."""

    def __init__(self):
        self.now_s, self.passes_s = 1000.0, 0.0

    def monotonic(self):
        self.now_s += self.passes_s
        return self.now_s

    def monotonic_ns(self):
        return round(1e9 * self.monotonic())

    def time_ns(self):
        return self.monotonic_ns()


class Ages(unittest.TestCase):
    def setUp(self):
        self.clock = Clock()
        patch = mock.patch.object(slipd, "time", self.clock)
        patch.start()
        self.addCleanup(patch.stop)

    def sent(self, **other):
        return slipd._estimate({**SENT, **other}, MAX_AGE_S)

    def old(self, **other):
        estimate = self.sent(**other)
        self.clock.now_s += 2 * MAX_AGE_S
        return estimate

    def test_a_young_estimate_says_what_slipd_sent(self):
        estimate = self.sent()
        self.assertEqual({key: getattr(estimate, key) for key in NOT_WHEN_OLD}, {key: SENT[key] for key in NOT_WHEN_OLD})
        self.assertEqual((estimate.state, estimate.alert, estimate.health), ("ok", "none", "good"))
        self.assertEqual(estimate.values, SENT)

    def test_all_that_must_not_be_acted_on_goes_together_once_it_is_old(self):
        estimate = self.old()
        self.assertEqual({key: getattr(estimate, key) for key in NOT_WHEN_OLD}, dict.fromkeys(NOT_WHEN_OLD))
        self.assertEqual((estimate.state, estimate.alert, estimate.health), ("stale", "unknown", "unknown"))
        gone = {key for key in SENT if SENT[key] is not None and estimate.values[key] is None}
        self.assertEqual(gone, {*NOT_WHEN_OLD, "class", "a_over_r", "grip_increase_sigma_n", "sliding_for_ms"})
        self.assertEqual([estimate.values[key] for key in ("state", "alert", "health")], ["stale", "unknown", "unknown"])

    def test_a_raised_alert_stands_however_old_it_is(self):
        for level in ("warn", "slip"):
            estimate = self.old(alert=level, alert_cause="sliding")
            self.assertEqual((estimate.alert, estimate.alert_cause, estimate.values["alert"]), (level, "sliding", level))

    def test_a_fault_stays_a_fault(self):
        self.assertEqual(self.old(state="fault", gamma=None).state, "fault")

    def test_what_slipd_does_not_say_is_unknown_and_an_alert_of_a_newer_slipd_is_a_slip(self):
        bare = slipd._estimate({"sensor": "left", "age_ms": 0}, MAX_AGE_S)
        self.assertEqual((bare.state, bare.alert, bare.health, bare.sliding), ("fault", "unknown", "unknown", None))
        self.assertEqual(self.sent(alert="panic").alert, "slip")

    def test_a_decision_of_several_reads_reads_one_judgement(self):
        self.clock.passes_s = 1e-5
        decided = set()
        for step in range(200):  # from young to too old by steps that are smaller than what the reads of one decision take
            estimate = self.sent(age_ms=1e3 * (MAX_AGE_S - 5e-4 + 5e-6 * step))
            if estimate.gamma is None:
                reads = [estimate.gamma, estimate.grip_increase_n, estimate.sigma, estimate.sliding, estimate.state, estimate.alert]
                self.assertEqual(reads, [None, None, None, None, "stale", "unknown"], step)
                decided.add("hold")
            else:
                reads = [estimate.gamma, estimate.grip_increase_n, estimate.sigma, estimate.sliding, estimate.state, estimate.alert]
                self.assertEqual(reads, [0.6, 0.2, 0.01, "none", "ok", "none"], step)
                decided.add("act")
        self.assertEqual(decided, {"hold", "act"})

    def test_a_kept_estimate_gets_stale_and_handing_it_out_again_makes_it_no_younger(self):
        kept = self.sent(age_ms=1e3 * MAX_AGE_S)
        for _ in range(10):
            self.clock.now_s += 0.1 * MAX_AGE_S
            self.assertEqual(kept.now().state, "stale")
        self.assertEqual((kept.state, kept.gamma, kept.alert), ("stale", None, "unknown"))
        young = self.sent()
        self.clock.now_s += 0.9 * MAX_AGE_S
        now = young.now()
        self.clock.now_s += 0.15 * MAX_AGE_S
        self.assertEqual((young.state, now.state), ("stale", "ok"), "what was handed out in time stands for one decision")

    def test_a_decision_takes_no_longer_than_twenty_milliseconds_however_old_an_estimate_may_be(self):
        late = slipd._estimate({**SENT, "age_ms": 990}, 1.0)
        self.clock.now_s += 0.019
        self.assertEqual(late.state, "ok")
        self.clock.now_s += 0.002
        self.assertEqual(late.state, "stale")

    def test_an_estimate_of_the_future_is_of_another_clock_and_has_no_margin(self):
        early = self.sent(age_ms=-1.0)
        self.assertEqual((early.state, early.gamma, early.alert), ("stale", None, "unknown"))
        cup = {"grasp": "cup", "sensors": ["left", "right"], "state": "ok", "gamma": 0.5}
        fingers = [{"sensor": "left", "age_ms": 3}, {"sensor": "right", "age_ms": -7}]
        self.assertIsNone(slipd._grasp({"sensors": fingers, "grasps": [cup]}, "cup", MAX_AGE_S).gamma)

    def test_any_age_is_not_no_age(self):
        self.assertIsNone(slipd._estimate({**SENT, "age_ms": None}, float("inf")).gamma)
        self.assertEqual(slipd._estimate({**SENT, "age_ms": 1e9}, float("inf")).gamma, 0.6)

    def test_the_age_counts_from_when_it_was_read_and_not_from_when_it_was_handed_out(self):
        lines = slipd._Lines()
        lines.take(b'{"jsonrpc":"2.0","method":"estimate","params":{"sensor":"left","state":"ok","gamma":0.6,"age_ms":0}}\n')
        self.clock.now_s += 2 * MAX_AGE_S  # the caller was busy with another one
        watch = slipd._Watch(MAX_AGE_S, ("estimate",))
        watch.begin(["left"])
        self.assertEqual(watch.fresh(*lines.notifications[0]).state, "stale")

    def test_whoever_is_told_of_silence_or_of_a_loss_is_told_the_alert_that_stands(self):
        watch = slipd._Watch(MAX_AGE_S, ("estimate",))
        watch.begin(["left", "right", "third"])
        watch.fresh("estimate", {**SENT, "alert": "slip", "alert_cause": "margin"}, self.clock.monotonic_ns())
        watch.fresh("estimate", {**SENT, "sensor": "right"}, self.clock.monotonic_ns())
        self.clock.now_s += 2 * MAX_AGE_S
        for told, state in ((watch.silent(), "stale"), (watch.lost(), "disconnected")):
            self.assertEqual([(each.name, each.state, each.alert, each.alert_cause, each.health) for each in told],
                             [("left", state, "slip", "margin", "unknown"), ("right", state, "unknown", None, "unknown"),
                              ("third", state, "unknown", None, "unknown")])


class RecordedEstimates(unittest.TestCase):
    def test_numbers_of_a_newer_slipd_are_a_fault_and_a_slip(self):
        reader = slipd.Recording.__new__(slipd.Recording)
        reader.start_monotonic_ns = 0
        for state, alert, told in ((0, 3, ("ok", "unknown")), (6, 2, ("stale", "slip")), (99, 99, ("fault", "slip"))):
            item = {"seq": 1, "time_ns": 2, "device_time_ns": None, "normal_pa": [], "shear_x_pa": [], "shear_y_pa": [],
                    "truth_gamma": None, "truth_friction": None, "estimate": {"state": state, "alert": alert}}
            with mock.patch.object(slipd, "_item", lambda data, at: (item, len(data))):
                frame, = reader._frames(b"x", 0)
            self.assertEqual((frame.estimate["state"], frame.estimate["alert"]), told)


if __name__ == "__main__":
    unittest.main()
