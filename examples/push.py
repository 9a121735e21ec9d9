#!/usr/bin/env python3
"""Frames of a sensor with a Python SDK to slipd, and its margin back: push.py [SENSOR [SOCKET]]

The sensor has "driver": "push" and 4 x 4 taxels in slipd's configuration, as in config/scenes/push-4x4.json."""
import sys
import time

import slipd


def read():
    """Replace this with your sensor's SDK: the force [x, y, z] of each taxel in N, z positive when pressed, at its rate."""
    time.sleep(0.01)
    return [[0.0, 0.0, 0.0]] * 16


def main(sensor="left", path=slipd.SOCKET):
    with slipd.Source(sensor, taxels=16, rate_hz=100, unit="N", path=path) as source, slipd.Client(path) as client:
        while True:
            source.push(read())
            now = client.gamma(sensor, max_age_s=0.1)
            print(now.state, now.gamma, now.sliding, flush=True)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except (slipd.SlipdError, OSError) as error:
        sys.exit(f"push: {error}")
    except KeyboardInterrupt:
        pass
