#!/usr/bin/env python3
"""load.py [PAGES [SECONDS [RATE_HZ [REALTIME]]]]: what live pages cost, by sockets that behave like them: each takes every estimate and every
picture of one sensor of 100 x 100 taxels. Prints the processor time of slipd-web and slipd, and the latency of slipd's estimates, without and with
pages, twice, SECONDS each. REALTIME: `realtime.mode` of slipd.json, without real time if it is absent; as root, prefer gives it. For docs/web.md;
judges nothing. SLIPD_BINARY_DIR and SLIPD_SOURCE_DIR as for the tests."""
import functools
import os
import re
import selectors
import socket
import sys
import time

from bed import Bed, WebSocket


PRIORITY = 10  # of SCHED_FIFO, below that of the kernel's interrupt threads


def one_sensor(rate_hz, realtime, folder):
    return {"sensors": [{"name": "left", "driver": "sim", "rate_hz": rate_hz}], "estimator": {"method": "moments"},
            "realtime": {"mode": realtime, "priority": PRIORITY}, "socket": {"path": f"{folder}/slipd.sock"}}


def seconds_of(program):
    """Processor time, s."""
    fields = open(f"/proc/{program.process.pid}/stat").read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Page:
    """Answers as the page does, without looking into what it gets."""

    def __init__(self, port):
        self.web = WebSocket(port)
        self.web.say("look left")
        self.web.socket.setblocking(False)
        self.buffer = bytearray(self.web.input)
        self.lives = self.pictures = 0

    def take(self):
        try:
            while more := self.web.socket.recv(1 << 18):
                self.buffer += more
        except BlockingIOError:
            pass
        while (length := self.length()) is not None:
            opcode, begin = self.buffer[0] & 15, bytes(self.buffer[:length])
            del self.buffer[:length]
            if opcode == 2:
                self.pictures += 1
                self.web.say("drawn")
            elif opcode == 1 and b'"live"' in begin:
                self.lives += 1
                self.web.say("ready")

    def length(self):
        """Of the first message, if it is whole."""
        data = self.buffer
        if len(data) < 10:
            return None
        short = data[1] & 127
        head, content = (2, short) if short < 126 else (4, int.from_bytes(data[2:4], "big")) if short == 126 else (10, int.from_bytes(data[2:10], "big"))
        return head + content if len(data) >= head + content else None


class Latencies:
    """From each frame's sample to its published estimate, µs, as slipd says with each estimate."""

    VALUE = re.compile(rb'"latency_us":([0-9.]+)')

    def __init__(self, folder):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(f"{folder}/slipd.sock")
        self.socket.sendall(b'{"jsonrpc":"2.0","id":1,"method":"subscribe"}\n')
        self.socket.setblocking(False)
        self.rest, self.values = b"", []

    def take(self):
        try:
            while more := self.socket.recv(1 << 18):
                lines, _, self.rest = (self.rest + more).rpartition(b"\n")
                self.values += map(float, self.VALUE.findall(lines))
        except BlockingIOError:
            pass

    def quantile(self, share):
        return sorted(self.values)[int(share * (len(self.values) - 1))]


def measured(bed, latencies, pages, seconds):
    selector = selectors.DefaultSelector()
    selector.register(latencies.socket, selectors.EVENT_READ, latencies)
    for page in pages:
        selector.register(page.web.socket, selectors.EVENT_READ, page)
        page.lives = page.pictures = 0
    latencies.take()
    latencies.values.clear()
    begin, web, daemon = time.monotonic(), seconds_of(bed.web), seconds_of(bed.slipd)
    while (left := begin + seconds - time.monotonic()) > 0:
        for key, _ in selector.select(left):
            key.data.take()
    passed = time.monotonic() - begin
    each = max(1, len(pages)) * passed
    return (f"{len(pages)} pages: slipd-web {100 * (seconds_of(bed.web) - web) / passed:.1f} % of a core, slipd {100 * (seconds_of(bed.slipd) - daemon) / passed:.1f} %; "
            f"each page {sum(p.lives for p in pages) / each:.1f} estimates/s and {sum(p.pictures for p in pages) / each:.1f} pictures/s; "
            f"latency p50 {latencies.quantile(0.5):.0f} µs, p99 {latencies.quantile(0.99):.0f} µs of {len(latencies.values)} estimates")


def main():
    count, seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 20, float(sys.argv[2]) if len(sys.argv) > 2 else 20
    rate_hz, realtime = float(sys.argv[3]) if len(sys.argv) > 3 else 1000, sys.argv[4] if len(sys.argv) > 4 else "off"
    bed = Bed(functools.partial(one_sensor, rate_hz, realtime))
    try:
        latencies = Latencies(bed.folder)
        for wanted in 2 * (0, count):
            pages = [Page(bed.port) for _ in range(wanted)]
            print(measured(bed, latencies, pages, seconds), flush=True)
            for page in pages:
                page.web.close()
        print(f"load average {os.getloadavg()[0]:.1f}; {bed.counts()}")
    finally:
        bed.close()


if __name__ == "__main__":
    main()
