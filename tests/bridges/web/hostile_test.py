#!/usr/bin/env python3
"""slipd-web against clients that mean harm or are broken: refused, counted, and others are served all the same."""
import contextlib
import json
import os
import socket
import struct
import tempfile
import time
import unittest

from awaiting import PATIENCE_S, await_true
from bed import Bed, WebSocket

HEAD_S = 5  # slipd-web gives a head this long


def status_of_upgrade(bed, **how):
    page = WebSocket(bed.port, **how)
    page.close()
    return page.status


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bed = Bed(slipd=False, max_browsers=4)

    @classmethod
    def tearDownClass(cls):
        assert cls.bed.web.process.poll() is None, cls.bed.web.said()
        cls.bed.close()

    def setUp(self):
        self.before = self.bed.counts()

    def counted(self, name):
        return self.bed.counts()[name] - self.before[name]

    def raw(self, content, answer=True):
        with socket.create_connection(("127.0.0.1", self.bed.port), timeout=PATIENCE_S) as client:
            client.sendall(content)
            out = b""
            with contextlib.suppress(ConnectionResetError):
                while answer and (more := client.recv(65536)):
                    out += more
            return out

    def test_every_answer_has_the_strict_headers(self):
        for target in ("/", "/app.js", "/api/counts", "/nothing"):
            headers = self.bed.get(target)[1]
            policy = headers["Content-Security-Policy"]
            self.assertIn("default-src 'none'", policy)
            self.assertNotIn("unsafe", policy)
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertIsNone(headers["Access-Control-Allow-Origin"])

    def test_the_page_is_small_and_loads_nothing_from_elsewhere(self):
        total = 0
        for name in os.listdir(os.environ["SLIPD_SOURCE_DIR"] + "/bridges/web/page"):
            status, _, content = self.bed.get("/" + name)
            self.assertEqual(status, 200, name)
            total += len(content)
            text = content.decode().replace("http://www.w3.org/2000/svg", "")
            self.assertNotRegex(text, r"https?://\w", name)
        self.assertLess(total, 150_000)

    def test_other_names_of_the_host_are_refused(self):
        for host in ("evil.example", f"evil.example:{self.bed.port}", "127.0.0.1", f"127.0.0.1:{self.bed.port + 1}", ""):
            self.assertEqual(self.bed.get("/", host=host)[0], 421, host)
        self.assertEqual(self.counted("refused_host"), 5)
        self.assertEqual(self.bed.get("/", host=f"LOCALHOST:{self.bed.port}")[0], 200)

    def test_pages_of_other_sites_are_refused(self):
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{self.bed.port}.evil.example", "", f"ftp://127.0.0.1:{self.bed.port}"):
            self.assertEqual(self.bed.get("/", Origin=origin)[0], 403, origin)
        self.assertEqual(self.upgraded(headers=["Origin: http://evil.example"]), 403)
        self.assertEqual(self.counted("refused_origin"), 6)
        self.assertEqual(self.upgraded(headers=[f"Origin: http://127.0.0.1:{self.bed.port}"]), 101)

    def test_it_is_read_only(self):
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH"):
            self.assertEqual(self.bed.get("/", method=method)[0], 405, method)
        self.assertEqual(self.bed.get("/", method="POST", body=b"x" * 10)[0], 413)
        self.assertEqual(self.bed.get("/", method="HEAD")[2], b"")

    def test_no_path_leads_out_of_its_folder(self):
        for target in ("/../etc/passwd", "/recordings/../slipd.json", "/recordings/..%2Fslipd.json", "/recordings/%2e%2e%2fweb.json", "/recordings/.rec",
                       "/recordings//etc/passwd", "/recordings/a%00.rec", "/%", "//", "/recordings/%zz.rec"):
            self.assertEqual(self.bed.get(target)[0], 404, target)

    def test_links_are_not_followed(self):
        (self.bed.folder / "recordings/link.rec").symlink_to(self.bed.settings)
        os.mkfifo(self.bed.folder / "recordings/pipe.rec")
        for name in ("link.rec", "pipe.rec"):
            self.assertEqual(self.bed.get(f"/recordings/{name}")[0], 404)
        self.assertEqual(json.loads(self.bed.get("/api/recordings")[2]), {"recordings": []})

    def test_what_is_no_http_is_refused(self):
        for content in (b"\r\n\r\n\r\n", b"GET\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET / HTTP/1.1\r\nHost\r\n\r\n",
                        b"GET / HTTP/9.9\r\n\r\n", b"GET / HTTP/1.1\r\nA: " + b"x" * 20000 + b"\r\n\r\n", b"GET /" + b"x" * 20000 + b" HTTP/1.1\r\n\r\n"):
            self.assertIn(self.raw(content)[:12], (b"HTTP/1.1 400", b"HTTP/1.1 421"), content[:40])
        self.assertGreaterEqual(self.counted("malformed"), 5)

    def test_two_hosts_are_none(self):
        own = f"Host: 127.0.0.1:{self.bed.port}\r\n".encode()
        self.assertIn(b" 421 ", self.raw(b"GET / HTTP/1.1\r\n" + own + own + b"\r\n"))

    def test_a_slow_loris_is_closed_and_others_are_served_meanwhile(self):
        slow = [socket.create_connection(("127.0.0.1", self.bed.port), timeout=PATIENCE_S) for _ in range(8)]
        for client in slow:
            client.sendall(b"GET / HTTP/1.1\r\nA: ")
        open_ones = set(slow)
        begin = time.monotonic()
        while open_ones and time.monotonic() - begin < PATIENCE_S:
            self.assertEqual(self.bed.get("/")[0], 200)
            for client in list(open_ones):
                client.settimeout(0.05)
                try:
                    client.sendall(b"x")  # drips on: the time is that of the whole head
                    if client.recv(1) == b"":
                        open_ones.remove(client)
                except (TimeoutError, BlockingIOError):
                    pass
                except OSError:
                    open_ones.discard(client)
        self.assertFalse(open_ones)
        self.assertGreaterEqual(time.monotonic() - begin, HEAD_S - 1)
        self.assertEqual(self.counted("slow"), 8)
        for client in slow:
            client.close()

    def test_no_more_connections_than_allowed(self):
        idle = [socket.create_connection(("127.0.0.1", self.bed.port), timeout=PATIENCE_S) for _ in range(40)]
        try:
            closed = 0
            for client in idle[25:]:
                with contextlib.suppress(ConnectionResetError):
                    client.settimeout(PATIENCE_S)
                    self.assertEqual(client.recv(1), b"")
                closed += 1
            self.assertEqual(closed, 15)
        finally:
            for client in idle:
                client.close()
        await_true(self.serves, "room again")
        self.assertGreaterEqual(self.counted("too_many"), 15)

    def serves(self):
        with contextlib.suppress(OSError):
            return self.bed.get("/")[0] == 200
        return False

    def test_no_more_live_pages_than_allowed(self):
        pages = [WebSocket(self.bed.port) for _ in range(4)]
        self.assertEqual({page.status for page in pages}, {101})
        self.assertEqual(self.upgraded(), 503)
        for page in pages:
            page.close()
        await_true(lambda: self.upgraded() == 101, "room again")

    def upgraded(self, **how):
        return status_of_upgrade(self.bed, **how)

    def ends(self, *messages, **how):
        """The close code with which a WebSocket is ended; None: without one."""
        page = WebSocket(self.bed.port)
        self.assertEqual(page.status, 101)
        try:
            for message in messages:
                page.say(message, **how)
            while True:
                opcode, content = page.next()
                if opcode == 8:
                    return struct.unpack(">H", content[:2])[0]
        except ConnectionError:
            return None
        finally:
            page.close()

    def test_messages_that_the_page_does_not_send_end_the_connection(self):
        for message in ("", "Ready", "look ", "look " + "x" * 64, "{}", "ready\n"):
            self.assertEqual(self.ends(message), 1008, message)
        self.assertEqual(self.ends(b"ready", opcode=2), 1008)
        self.assertGreaterEqual(self.counted("bad_messages"), 7)

    def test_huge_and_broken_frames_end_the_connection(self):
        self.assertEqual(self.ends("look " + "x" * 300), 1009)
        self.assertIn(self.ends("ready", masked=False), (1002, None))
        self.assertIn(self.ends("ready", opcode=5), (1002, None))
        page = WebSocket(self.bed.port)
        page.socket.sendall(b"\x81\xff" + b"\x7f" + b"\xff" * 7)  # promises 2^63 bytes
        with contextlib.suppress(ConnectionError):
            while page.next()[0] != 8:
                pass
        page.close()

    def test_a_flood_of_messages_ends_the_connection(self):
        self.assertIn(self.ends(*["look nobody"] * 5000), (1008, None))

    def test_a_page_that_never_reads_costs_little(self):
        deaf = WebSocket(self.bed.port)
        live = WebSocket(self.bed.port)
        for _ in range(20):
            live.message("live")
        self.assertEqual(self.bed.get("/")[0], 200)
        deaf.close()
        live.close()

    def test_without_slipd_the_page_says_why(self):
        page = WebSocket(self.bed.port)
        message = page.message("live")
        self.assertEqual(message["slipd"], "away")
        self.assertIn("slipd does not run here", message["why"])
        page.close()


class Token(unittest.TestCase):
    def test_nothing_is_served_without_the_token(self):
        with tempfile.NamedTemporaryFile("w", suffix=".token") as file:
            file.write("0123456789abcdef0123\n")
            file.flush()
            bed = Bed(slipd=False, token_file=file.name)
            try:
                for target in ("/", "/app.js", "/api/counts", "/?token=wrong", "/?token="):
                    self.assertEqual(bed.get(target)[0], 401, target)
                self.assertEqual(status_of_upgrade(bed), 401)
                status, headers, _ = bed.get("/?token=0123456789abcdef0123")
                self.assertEqual((status, headers["Location"]), (303, "./"))
                self.assertIn("HttpOnly", headers["Set-Cookie"])
                self.assertIn("SameSite=Strict", headers["Set-Cookie"])
                cookie = headers["Set-Cookie"].split(";")[0]
                self.assertEqual(bed.get("/", Cookie=cookie)[0], 200)
                self.assertEqual(cookie, f"slipd-token-{bed.port}=0123456789abcdef0123")
                # The cookie of another port's page comes along: it is neither taken nor in the way.
                other = "slipd-token-1=" + cookie.split("=")[1]
                self.assertEqual(bed.get("/", Cookie=other)[0], 401)
                self.assertEqual(bed.get("/", Cookie="slipd-token-1=fedcba9876543210; " + cookie)[0], 200)
                self.assertEqual(bed.get("/", Authorization="Bearer 0123456789abcdef0123")[0], 200)
                self.assertEqual(status_of_upgrade(bed, headers=["Cookie: a=b; " + cookie]), 101)
                self.assertEqual(bed.get("/", Cookie=cookie[:-1])[0], 401)
                self.assertEqual(bed.get("/", Cookie=cookie + "0")[0], 401)
            finally:
                bed.close()


if __name__ == "__main__":
    unittest.main()
