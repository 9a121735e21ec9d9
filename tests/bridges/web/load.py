#!/usr/bin/env python3
"""load.py [PAGES [SECONDS]]: what live pages cost, by sockets that behave like them: each takes every estimate and every picture of one
sensor of 100 x 100 taxels. Prints the processor time of slipd-web and slipd, and the estimate thread's latency, without and with pages.
For docs/web.md; judges nothing. SLIPD_BINARY_DIR and SLIPD_SOURCE_DIR as for the tests."""
import os
import selectors
import sys
import time

from bed import Bed, WebSocket


def one_sensor(folder):
    return {"sensors": [{"name": "left", "driver": "sim"}], "estimator": {"method": "moments"}, "realtime": {"mode": "off"}, "socket": {"path": f"{folder}/slipd.sock"}}


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


def latency(bed):
    import json
    import socket
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(f"{bed.folder}/slipd.sock")
        client.sendall(b'{"jsonrpc":"2.0","id":1,"method":"status"}\n')
        text = b""
        while not text.endswith(b"\n"):
            text += client.recv(1 << 20)
    return json.loads(text)["result"]["sensors"][0]["latency_last_minute_us"]


def measured(bed, pages, seconds):
    selector = selectors.DefaultSelector()
    for page in pages:
        selector.register(page.web.socket, selectors.EVENT_READ, page)
    begin, web, daemon = time.monotonic(), seconds_of(bed.web), seconds_of(bed.slipd)
    for page in pages:
        page.lives = page.pictures = 0
    while (left := begin + seconds - time.monotonic()) > 0:
        for key, _ in selector.select(min(left, 0.1)) if pages else [time.sleep(min(left, 0.1))] and []:
            key.data.take()
    passed = time.monotonic() - begin
    return {"slipd-web": (seconds_of(bed.web) - web) / passed, "slipd": (seconds_of(bed.slipd) - daemon) / passed,
            "lives": sum(p.lives for p in pages) / passed / max(1, len(pages)), "pictures": sum(p.pictures for p in pages) / passed / max(1, len(pages))}


def main():
    count, seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 20, float(sys.argv[2]) if len(sys.argv) > 2 else 30
    bed = Bed(one_sensor)
    try:
        for wanted in (0, count):
            pages = [Page(bed.port) for _ in range(wanted)]
            result = measured(bed, pages, seconds)
            print(f"{len(pages)} pages: slipd-web {100 * result['slipd-web']:.1f} % of a core, slipd {100 * result['slipd']:.1f} %, "
                  f"each page {result['lives']:.1f} estimates/s and {result['pictures']:.1f} pictures/s; latency µs {latency(bed)}; {bed.counts()}")
    finally:
        bed.close()


if __name__ == "__main__":
    main()
