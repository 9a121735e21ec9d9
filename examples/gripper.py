#!/usr/bin/env python3
"""A gripper's loop in Python, on slipd's socket: gripper.py SENSOR [SOCKET [GRIP_INPUT]]

Prints a line for each change of state or force. GRIP_INPUT: datagram socket of a simulated sensor."""
import socket
import sys

import slipd

FIRM_N = 6.0  # without a margin: holds each object, breaks none
MOST_N = 8.0  # what no object is harmed by
SHARE_MORE = 1.1  # on an alert without advice
MAX_AGE_S = 0.1  # some frames, and less than the time in which an object slips


def command(force_n, grip_input):
    """Replace this with your gripper's command."""
    if grip_input is None:
        return
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
        out.setblocking(False)
        try:
            out.sendto(f"{force_n:.3f}".encode(), grip_input)
        except OSError:
            pass  # the simulated sensor is away, too


def next_force(force_n, now):
    """The force after an estimate. It never lets go by itself: when to do so depends on the task."""
    if now.state != "ok" or now.alert == "unknown":
        force_n = max(force_n, FIRM_N)
    if now.alert not in ("warn", "slip"):
        return force_n
    return min(MOST_N, max(force_n + (now.grip_increase_n or 0.0), force_n * SHARE_MORE))


def main(sensor, path=slipd.SOCKET, grip_input=None):
    force_n, before = FIRM_N, None
    with slipd.Client(path) as client:
        for now in client.estimates(sensor, max_age_s=MAX_AGE_S):
            wanted_n = next_force(force_n, now)
            if (wanted_n, now.state, now.alert) != before:
                gamma = float("nan") if now.gamma is None else now.gamma
                print(f"{now.state} {now.alert} margin {gamma:.3f} force {wanted_n:.2f} N", flush=True)
            force_n, before = wanted_n, (wanted_n, now.state, now.alert)
            command(force_n, grip_input)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except (slipd.SlipdError, OSError) as error:
        sys.exit(f"gripper: {error}")
    except KeyboardInterrupt:
        pass
