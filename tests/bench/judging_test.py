#!/usr/bin/python3
"""How tools/bench judges: ratios and nothing else, and no peer that is not at its best. Made-up figures; nothing is measured."""
import dataclasses
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from goals import Goal, goals, judge, size  # noqa: E402
from measured import Measured  # noqa: E402
from peer_check import blas_refusal, missing_refusal  # noqa: E402
from report import page  # noqa: E402

OPENBLAS = {"user_api": "blas", "internal_api": "openblas", "num_threads": 4, "version": "0.3.21", "threading_layer": "pthreads"}
AT_MOST_TWICE = Goal("estimate", 9.0, "µs", "copy", 5.0, 2, "the reason")
AS_MANY = Goal("queries", 90.0, "a second", "Redis GET", 100.0, 1, "the reason", more=True, peer="Redis")


def with_times(goal, ours, base):
    return dataclasses.replace(goal, ours=ours, base=base)


class Judging(unittest.TestCase):
    def test_a_ratio_within_its_limit_is_met_and_one_beyond_it_missed_by_how_much(self):
        self.assertEqual(judge(AT_MOST_TWICE), "met")
        self.assertEqual(judge(with_times(AT_MOST_TWICE, 10.0, 5.0)), "met")
        self.assertEqual(judge(with_times(AT_MOST_TWICE, 12.0, 5.0)), "missed by 20 %")

    def test_where_more_is_better_the_limit_is_the_least(self):
        self.assertEqual(judge(AS_MANY), "missed by 11 %")
        self.assertEqual(judge(with_times(AS_MANY, 110.0, 100.0)), "met")

    def test_a_machine_half_as_fast_changes_no_verdict(self):
        for goal in (AT_MOST_TWICE, with_times(AT_MOST_TWICE, 12.0, 5.0), AS_MANY):
            self.assertEqual(judge(goal), judge(with_times(goal, 2 * goal.ours, 2 * goal.base)))

    def test_nothing_is_said_without_both_times(self):
        self.assertEqual(judge(with_times(AT_MOST_TWICE, None, 5.0)), "not measured")
        self.assertEqual(judge(with_times(AT_MOST_TWICE, 9.0, None)), "not measured")

    def test_a_size_is_judged_as_it_is(self):
        self.assertEqual(judge(size("memory", 14.0, 15, "MB", "the reason")), "met")
        self.assertEqual(judge(size("memory", 18.0, 15, "MB", "the reason")), "missed by 20 %")

    def test_a_goal_against_a_peer_that_is_left_out_is_not_judged_however_good_it_looks(self):
        self.assertEqual(judge(with_times(AS_MANY, 17700.0, 100.0), {"Redis"}), "not judged: Redis is left out")
        self.assertEqual(judge(AT_MOST_TWICE, {"Redis"}), "met")


class Peers(unittest.TestCase):
    def test_openblas_on_all_cores_is_accepted(self):
        self.assertIsNone(blas_refusal([OPENBLAS], 4))
        self.assertIsNone(blas_refusal([OPENBLAS], 2))

    def test_the_reference_blas_is_refused_with_what_to_install(self):
        openmp = {"user_api": "openmp", "internal_api": "openmp", "num_threads": 4}
        for pools in ([], [openmp]):
            answer = blas_refusal(pools, 4)
            self.assertIn("reference BLAS", answer["why"])
            self.assertIn("libopenblas0-pthread", answer["remedy"])

    def test_one_thread_is_refused_where_there_are_more_cores(self):
        alone = {**OPENBLAS, "num_threads": 1}
        self.assertIsNone(blas_refusal([alone], 1))
        self.assertIn("1 of 4 cores", blas_refusal([alone], 4)["why"])
        self.assertIn("libopenblas0-pthread", blas_refusal([{**alone, "threading_layer": "disabled"}], 4)["remedy"])


class Page(unittest.TestCase):
    def setUp(self):
        left_out = missing_refusal("scikit-learn", "Python's sklearn", "python3-sklearn")
        machine = {"processor": "one", "virtual": False, "cores": 2, "caches": {}, "memory_mb": 1, "vectors": [], "kernel": "6.1",
                   "compiler": "g++", "load_before": 0.1, "date": "today", "commit": "abc"}
        self.of = Measured({"minutes": 1, "machine": machine, "paths": {},
                            "estimators": {"ours": {"method/svd-knn/100": {"p50_us": 9.0}, "floor/memcpy": {"p50_us": 4.5},
                                                    "floor/search": {"p50_us": 0.5}}, "peer": [left_out]},
                            "training": {"ours": [], "peer": [left_out]},
                            "daemon": [missing_refusal("Redis", "redis-server", "redis-server")]})
        self.goals = list(goals(self.of))

    def test_what_was_measured_is_judged_beside_what_was_not(self):
        judged = {(goal.what, goal.against): judge(goal, self.of.refused) for goal in self.goals}
        self.assertEqual(judged["svd-knn, 100 x 100", "frame and basis copied, exact search"], "met")
        self.assertEqual(judged["svd-knn, 100 x 100", "frame projected, exact search"], "not measured")
        self.assertEqual(judged["svd-knn, 100 x 100", "scikit-learn batched"], "not judged: scikit-learn is left out")
        self.assertEqual(judged["gamma, 1 client, queries", "Redis GET"], "not judged: Redis is left out")

    def test_each_peer_left_out_is_named_once(self):
        self.assertEqual(sorted(self.of.refused), ["Redis", "scikit-learn"])

    def test_the_page_says_what_is_missing_and_what_to_do(self):
        text = page(self.of, drawn=False)
        self.assertIn("* Redis: redis-server is not installed; install redis-server (tools/setup --bench does).", text)
        self.assertIn("| ≤ 2.00 | 1.80 | met |", text)
        self.assertNotIn("None", text)

    def test_no_time_is_judged_by_itself(self):
        for goal in self.goals:
            if goal.unit in ("µs", "ms", "s", "a second", "% of a core"):
                self.assertTrue(goal.against, goal.what)


if __name__ == "__main__":
    unittest.main()
