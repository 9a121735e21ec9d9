"""slipd-feed between servers and the real slipd. The WebSocket servers are python3-websockets' and npm's `ws`; the datagrams are what PyTac3D reads."""
import asyncio, json, os, signal, socket, struct, subprocess, sys, tempfile, threading, time, unittest
from pathlib import Path

import slipd
import websockets
from awaiting import PATIENCE_S, await_true
from margins_of_messages import MarginsOfMessages
from ports import free_port

SOURCE = os.environ["SLIPD_SOURCE_DIR"]
sys.path.insert(0, os.path.join(SOURCE, "tests", "clients"))
from push_test import HELD, NOTHING, PITCH_M, SIDE, Scene  # contacts of Cattaneo and Mindlin, in Pa

BUILD = os.environ["SLIPD_BINARY_DIR"]
TAXELS = SIDE ** 2
WAITING = 10  # datagrams that the kernel keeps for a socket, whatever it is set to
SMALL = 100  # frames slipd hears of what the test does not want used: so many chances to use one


def newtons(frame):
    """The force of each taxel, one list."""
    return [value * PITCH_M ** 2 for taxel in frame for value in taxel]


class Program:
    """slipd-feed with one feed of the sensor left."""

    def __init__(self, daemon, **feed):
        self.settings = os.path.join(daemon.folder.name, "feed.json")
        with open(self.settings, "w") as file:
            json.dump({"socket": daemon.socket, "feeds": [{"sensor": "left", "taxels": TAXELS, **feed}]}, file)
        self.log_file = os.path.join(daemon.folder.name, "feed.log")
        with open(self.log_file, "w") as log:
            self.process = subprocess.Popen([os.path.join(BUILD, "bin", "slipd-feed"), "--config", self.settings], stderr=log, stdout=log)

    def log(self):
        with open(self.log_file) as log:
            return log.read()

    def end(self):
        """Its counts, by name."""
        if self.process.returncode is None:
            self.process.terminate()
            assert self.process.wait(PATIENCE_S) == 0, self.log()
        summary = [line for line in self.log().splitlines() if "messages," in line][-1]
        return {name: int(count) for count, name in (each.split(" ", 1) for each in summary.split("left: ")[1].split(", "))}


class FeedTest(MarginsOfMessages, unittest.TestCase):
    """What every source has: `frame_message(frame)` makes the next message, `send(message)` sends it."""

    def setUp(self):
        self.daemon = Scene(max_age_ms=100)
        self.addCleanup(self.daemon.close)
        self.client = slipd.Client(self.daemon.socket, timeout_s=PATIENCE_S)
        self.addCleanup(self.client.close)
        await_true(lambda: os.path.exists(os.path.join(self.daemon.folder.name, "push", "left")), "the sensor's socket")
        self.index = 0

    def feed(self, **settings):
        self.program = Program(self.daemon, **settings)
        self.addCleanup(self.program.end)

    def counts(self):
        return self.client.call("status")["sensors"][0]


class Datagrams(FeedTest):
    """As Tac3D-Desktop sends: the first datagram is YAML, matrices follow."""

    def setUp(self):
        super().setUp()
        self.port, self.number = free_port(), 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)

    def feed(self):
        super().feed(profile="tac3d", **{"from": f"udp://127.0.0.1:{self.port}"}, device="AD2-0046R")
        # A port of UDP cannot be asked whether somebody listens.
        await_true(lambda: f":{self.port:04X} " in Path("/proc/net/udp").read_text(), "its port")

    def frame_message(self, frame, sn="AD2-0046R", values=None, ready=100, index=None, at_s=None):
        """The datagrams of one frame."""
        self.index += 1
        values = newtons(frame) if values is None else values
        other, forces, progress = struct.pack("<6d", *range(6)), struct.pack(f"<{len(values)}d", *values), struct.pack("<i", ready)
        entries, at = [], 0
        for name, kind, block, height in (("3D_Positions", "mat", other, 2), ("3D_Forces", "mat", forces, len(values) // 3),
                                          ("InitializeProgress", "i32", progress, 1)):
            entries.append(f"- {{name: {name}, type: {kind}, dtype: f64, width: 3, height: {height}, offset: {at}, length: {len(block)}}}\n")
            at += len(block)
        head = f"index: {self.index if index is None else index}\nSN: {sn}\ntimestamp: {at_s or time.monotonic()}\ndata:\n" + "".join(entries)
        body = other + forces + progress
        parts = [head.encode(), *(body[i:i + 1400] for i in range(0, len(body), 1400))]
        self.number += 1
        return [struct.pack("<IHH", self.number, len(parts) - 1, i) + part for i, part in enumerate(parts)]

    def send(self, datagrams):
        for datagram in datagrams:
            self.socket.sendto(datagram, ("127.0.0.1", self.port))

    def test_frames_of_datagrams_give_the_margin_of_the_contact(self):
        self.feed()
        self.hold(0.3)
        self.hold(0.6)
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["repeated"], counts["lost"]), (0, 0, 0))
        self.assertEqual(counts["messages"], self.index)

    def test_datagrams_in_any_order_make_the_same_frame(self):
        self.feed()
        frame_message = self.frame_message
        self.frame_message = lambda frame: frame_message(frame)[::-1]
        self.hold()

    def test_broken_messages_are_counted_and_give_no_margin(self):
        self.feed()
        self.hold()
        whole = newtons(HELD)
        corrupt = [self.frame_message(HELD, values=[float("nan"), *whole[1:]]), self.frame_message(HELD, values=[1e300, *whole[1:]]),
                   self.frame_message(HELD, values=whole[:-3]), [b"no header"], [b""]]
        other = [self.frame_message(HELD, sn="another"), self.frame_message(HELD, ready=99)]
        halves = [self.frame_message(HELD)[:-1], self.frame_message(HELD)[1:]]
        self.never_a_margin(corrupt + other + halves)
        self.send_until(HELD, lambda each: each.gamma is not None, "a whole one")
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["other"]), (len(corrupt), len(other)))
        self.assertEqual(counts["lost"], len(corrupt) - 2 + len(other) + len(halves))

    def test_a_frame_that_comes_again_is_counted_and_not_used(self):
        self.feed()
        self.hold()
        again = self.frame_message(HELD)
        for _ in range(2):
            self.number += 1
            self.send([struct.pack("<I", self.number) + datagram[4:] for datagram in again])
        self.send_until(HELD, lambda each: self.index > 20, "more")
        self.assertEqual(self.program.end()["repeated"], 1)

    def test_what_was_under_way_for_long_is_no_frame(self):
        self.feed()
        self.hold()
        late = [self.frame_message(HELD) for _ in range(SMALL)]
        corrupt = self.counts()["corrupt"]
        self.never_a_margin(late)
        self.assertGreaterEqual(self.counts()["corrupt"] - corrupt, SMALL - 1)

    def test_a_sender_that_begins_anew_is_heard(self):
        self.feed()
        self.hold()
        self.index, self.number = 0, 0
        self.hold(0.5)


class Untimed(FeedTest):
    """A force sensor whose messages, one datagram each, have no time."""

    def test_of_messages_that_waited_only_the_last_is_used(self):
        port = free_port()
        with open(os.path.join(self.daemon.folder.name, "cell.json"), "w") as file:
            json.dump({"description": "a cell", "tested": "synthetic", "source": "this test", "from": f"udp://127.0.0.1:{port}", "format": "bytes",
                       "unit": "Pa", "values": {"offset": 0, "type": "f32be"}}, file)
        self.feed(profile=os.path.join(self.daemon.folder.name, "cell.json"))
        await_true(lambda: f":{port:04X} " in Path("/proc/net/udp").read_text(), "its port")
        self.program.process.send_signal(signal.SIGSTOP)
        os.waitpid(self.program.process.pid, os.WUNTRACED)  # until it has stopped
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for _ in range(WAITING):
                sender.sendto(struct.pack(f">{3 * TAXELS}f", *(value for taxel in HELD for value in taxel)), ("127.0.0.1", port))
        self.program.process.send_signal(signal.SIGCONT)
        await_true(lambda: self.counts()["received"] > 0, "the last one")
        counts = self.program.end()
        self.assertEqual((counts["messages"], counts["overtaken"], counts["frames sent"]), (WAITING, WAITING - 1, 1))


class Server:
    """A WebSocket server that sends every client what it is told."""

    def __init__(self, port):
        self.port, self.clients, self.loop = port, set(), asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever)
        self.thread.start()
        self.begin()

    def begin(self):
        async def serve():
            return await websockets.serve(self._serve, "127.0.0.1", self.port)
        self.server = self._do(serve())

    def send(self, text):
        async def send():
            for client in list(self.clients):
                await client.send(text)
        self._do(send())

    def end(self):
        self.loop.call_soon_threadsafe(self.server.close)
        self._do(self.server.wait_closed())

    def close(self):
        self.end()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()

    async def _serve(self, client):
        await client.send('{"message": "Welcome"}')
        self.clients.add(client)
        await client.wait_closed()
        self.clients.discard(client)

    def _do(self, what):
        return asyncio.run_coroutine_threadsafe(what, self.loop).result(PATIENCE_S)


class NpmServer:
    """The same of npm's `ws`, which compresses messages and sends each in two fragments."""

    def __init__(self, port):
        self.port, self.clients = port, 0
        self.begin()

    def begin(self):
        here = os.path.dirname(os.path.realpath(__file__))
        self.program = subprocess.Popen(["node", os.path.join(here, "server.mjs"), str(self.port)], cwd=os.environ["SLIPD_PEERS_NPM"],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.thread = threading.Thread(target=self._count)
        self.thread.start()

    def send(self, text):
        self.program.stdin.write(json.dumps(text) + "\n")
        self.program.stdin.flush()

    def end(self):
        """Once all that it was told is sent."""
        if self.program.returncode is None:
            self.program.stdin.close()
            self.program.wait(PATIENCE_S)
            self.thread.join()
            self.program.stdout.close()
            self.clients = 0

    def close(self):
        self.end()

    def _count(self):
        for line in self.program.stdout:
            self.clients = int(line)


class WebSocket(FeedTest):
    """As XELA's server sends."""
    Server = Server

    def setUp(self):
        super().setUp()
        self.port = free_port()

    def serve(self):
        self.server = self.Server(self.port)
        self.addCleanup(self.server.close)

    def feed(self, profile="xela-server"):
        super().feed(profile=profile, **{"from": f"ws://127.0.0.1:{self.port}/"}, device="2")

    def await_client(self):
        await_true(lambda: self.server.clients, "the client")

    def frame_message(self, frame, values=None, **more):
        self.index += 1
        sensor = {"sensor": "2", "model": "uSPa44", "time": time.time(), "taxels": TAXELS, "data": ",".join(["8000"] * 3 * TAXELS),
                  "calibrated": newtons(frame) if values is None else values, **more}
        other = {**sensor, "sensor": "1", "calibrated": [9.0] * 3 * TAXELS}
        return json.dumps({"message": self.index, "1": other, "2": sensor})

    def send(self, text):
        self.server.send(text)

    def test_frames_of_a_server_give_the_margin_of_the_contact(self):
        self.serve()
        self.feed()
        self.await_client()
        self.hold(0.3)
        self.hold(0.6)
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["repeated"], counts["other"]), (0, 0, 1))  # the welcome

    def test_a_server_that_is_gone_is_stale_and_one_that_is_back_gives_margins_again(self):
        self.feed()
        await_true(lambda: "cannot connect" in self.program.log(), "word of the server")
        self.serve()
        self.await_client()
        self.hold()
        self.server.end()
        await_true(lambda: self.estimate().state == "fault", "no frames")
        self.assertIsNone(self.estimate().gamma)
        await_true(lambda: self.program.log().count("cannot connect") == 2, "word of the loss")
        self.server.begin()
        self.await_client()
        self.hold(0.5)

    def test_broken_texts_are_counted_and_give_no_margin(self):
        self.serve()
        self.feed()
        self.await_client()
        self.hold()
        whole = newtons(HELD)
        corrupt = [self.frame_message(HELD)[:-20], "", "[1, 2", self.frame_message(HELD, values=whole[1:]), self.frame_message(HELD, values=[*whole, 0.0]),
                   self.frame_message(HELD, values=["x", *whole[1:]]), self.frame_message(HELD, values=[None, *whole[1:]]),
                   self.frame_message(HELD, values=[float("nan"), *whole[1:]]), self.frame_message(HELD).replace('"time": 1', '"time": 1e999'),
                   self.frame_message(HELD, values=[1e60, *whole[1:]]), self.frame_message(HELD, time="now")]
        other = ["{}", "[]", "7", '{"message": 1, "2": {}}']
        self.never_a_margin(corrupt + other)
        self.server.end()
        await_true(lambda: "cannot connect" in self.program.log(), "word of the loss, behind all messages")
        counts = self.program.end()
        self.assertEqual((counts["corrupt"], counts["other"]), (len(corrupt), len(other) + 1))

    def test_a_burst_after_a_pause_is_late(self):
        self.serve()
        self.feed()
        self.await_client()
        self.hold()
        late = [self.frame_message(HELD) for _ in range(SMALL)]
        self.never_a_margin(late)

    def test_counts_without_a_calibration_give_no_margin(self):
        self.serve()
        self.feed("xela-server-raw")
        self.await_client()
        estimate = self.send_until(NOTHING, lambda each: each.state == "unzeroed", "counts")
        self.assertIsNone(estimate.gamma)


@unittest.skipUnless("SLIPD_PEERS_NPM" in os.environ, "the peers of npm have a test of their own")
class WebSocketOfNpm(WebSocket):
    Server = NpmServer


class Settings(unittest.TestCase):
    def refusal(self, **feed):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"feeds": [{"sensor": "left", "profile": "tac3d", **feed}]}, file)
            file.flush()
            checked = subprocess.run([os.path.join(BUILD, "bin", "slipd-feed"), "--config", file.name, "--check-config"], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 2, checked.stdout)
        return checked.stderr

    def test_an_open_port_needs_a_sender(self):
        self.assertIn('add "sender"', self.refusal(**{"from": "udp://0.0.0.0:9988"}))

    def test_wrong_settings_are_refused_with_what_to_do(self):
        self.assertIn("there is no profile", self.refusal(profile="tactile"))
        self.assertIn("expected udp://", self.refusal(**{"from": "tcp://127.0.0.1:1"}))
        self.assertIn("expected udp://", self.refusal(**{"from": "ws://127.0.0.1:1/"}))
        self.assertIn('add "taxels"', self.refusal(profile="xela-server"))


del FeedTest  # has no tests of its own
if __name__ == "__main__":
    unittest.main(verbosity=2)
