"""slipd-bench: slip detectors on recordings with a truth. docs/slipd-bench.md is its page."""
