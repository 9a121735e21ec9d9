"""Waiting for an event that another program does not tell, in tests in Python."""
import time

PATIENCE_S = 300  # only what hangs takes this long, on any machine under any load
PAUSE_S = 0.02


def await_true(condition, what, patience_s=PATIENCE_S):
    """What `condition` returns once it is true. `what`: the event, for the message."""
    until = time.monotonic() + patience_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > until:
            raise AssertionError(f"waited in vain for {what}, {patience_s} s")
        time.sleep(PAUSE_S)
