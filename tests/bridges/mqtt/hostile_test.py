"""slipd-mqtt with brokers that misbehave: it leaves each of them for the next, keeps its alerts, and ends when it is asked to. Where what a
broker sends ends the program itself, its service starts it anew, and it goes on with the next."""
import os, random, socket, threading, time, unittest

from awaiting import await_true
from support import BridgeTest


class HostileBroker:
    """Does `behave(connection)` in a thread for each connection."""

    def __init__(self, behave):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.connections = 0
        self.behave = behave
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._run, args=(connection,), daemon=True).start()

    def _run(self, connection):
        try:
            self.behave(connection)
        except OSError:
            pass
        finally:
            connection.close()


def read_packet(connection):
    """(first byte, body) of one MQTT packet; None at the end."""
    def exactly(count):
        data = b""
        while len(data) < count:
            got = connection.recv(count - len(data))
            if not got:
                return None
            data += got
        return data
    first = exactly(1)
    if first is None:
        return None
    length, shift = 0, 0
    while True:
        byte = exactly(1)
        if byte is None:
            return None
        length |= (byte[0] & 0x7F) << shift
        shift += 7
        if not byte[0] & 0x80:
            break
    return first[0], exactly(length) if length else b""


CONNACK, CONNACK_5 = b"\x20\x02\x00\x00", b"\x20\x03\x00\x00\x00"
VERSION_REFUSED = b"\x20\x02\x00\x01"


def good(published):
    """A broker of MQTT 3.1.1 that refuses MQTT 5, acknowledges, and keeps (topic, payload) of QoS 1."""
    def behave(connection):
        while (packet := read_packet(connection)) is not None:
            kind, body = packet
            if kind >> 4 == 1 and body[6] > 4:
                connection.sendall(VERSION_REFUSED)
                return
            if kind >> 4 == 1:
                connection.sendall(CONNACK)
            elif kind >> 4 == 12:
                connection.sendall(b"\xd0\x00")
            elif kind >> 4 == 3 and kind & 6:
                length = int.from_bytes(body[:2], "big")
                published.append((body[2:2 + length].decode(), body[4 + length:]))
                connection.sendall(b"\x40\x02" + body[2 + length:4 + length])
    return behave


def silent(connection):
    while connection.recv(65536):
        pass


def closes_in_a_packet(connection):
    connection.recv(65536)
    connection.sendall(b"\x20\x02")


def garbage(seed):
    def behave(connection):
        connection.sendall(random.Random(seed).randbytes(4096))
        silent(connection)
    return behave


def unknown_property(connection):
    read_packet(connection)
    connection.sendall(b"\x20\x05\x00\x00\x02\x7f\x00")
    silent(connection)


def closes_at_once(connection):
    pass


def refuses(connection):
    read_packet(connection)
    connection.sendall(b"\x20\x03\x00\x87\x00")


def accepts_and_closes(connection):
    read_packet(connection)
    connection.sendall(CONNACK_5)


def huge_packet(connection):
    read_packet(connection)
    connection.sendall(CONNACK_5 + b"\x30\xff\xff\xff\x7f" + b"x" * 65536)
    silent(connection)


def acknowledges_nonsense(connection):
    read_packet(connection)
    connection.sendall(CONNACK_5 + b"".join(b"\x40\x02" + n.to_bytes(2, "big") for n in range(60_000, 62_000)))
    connection.sendall(b"\x62\x02\x00\x01\x70\x02\x00\x01\x90\x03\x00\x01\x00\xb0\x02\x00\x01")
    closes_at_once(connection)


class Hostile(BridgeTest):
    def setUp(self):
        super().setUp()
        self.slipd = self.fake_slipd(sensors=["left"])

    def bridge(self, *brokers, **more):
        return self.bridge_of(self.slipd, brokers, **more)

    def alerts_pass(self, behave, ends_it=False):
        """With a broker that behaves so and then a good one, alerts arrive in order at the good one. `ends_it`: the former ends slipd-mqtt."""
        published = []
        hostile, friendly = HostileBroker(behave), HostileBroker(good(published))
        bridge = self.bridge(hostile, friendly, restarts=ends_it)
        if ends_it:
            await_true(lambda: friendly.connections and self.slipd.subscribers(bridge.program.pid), "slipd-mqtt that was started anew")
        alerts = [self.slipd.alert("left") for _ in range(20)]
        def numbers():
            return [int(payload.split(b'"number":')[1].split(b",")[0]) for topic, payload in published if topic.endswith("/alert")]
        await_true(lambda: len(set(numbers())) == len(alerts), "the alerts; got %s; %s" % (numbers(), bridge.log()))
        self.assertEqual(list(dict.fromkeys(numbers())), list(range(1, 21)))
        self.assertGreater(hostile.connections, 0)
        self.assertEqual(bridge.stop(), 0, bridge.log())
        self.assertEqual("has its turn" in bridge.log(), ends_it, bridge.log())

    def test_closes_at_once(self):
        self.alerts_pass(closes_at_once)

    def test_closes_in_a_packet(self):
        self.alerts_pass(closes_in_a_packet)

    def test_sends_garbage(self):
        self.alerts_pass(garbage(1))

    # As one of fourteen does.
    def test_sends_garbage_that_ends_the_program(self):
        self.alerts_pass(garbage(3), ends_it=True)

    # libmosquitto 2.0.11 aborts. A start that went back to this broker would never get to the next.
    def test_ends_the_program(self):
        self.alerts_pass(unknown_property, ends_it=True)

    def test_refuses(self):
        self.alerts_pass(refuses)

    def test_accepts_and_closes(self):
        self.alerts_pass(accepts_and_closes)

    def test_announces_a_huge_packet(self):
        self.alerts_pass(huge_packet)

    def test_accepts_the_connection_and_never_answers(self):
        self.alerts_pass(silent)

    # Acknowledgements of messages that were never sent remove nothing.
    def test_acknowledges_nonsense(self):
        self.alerts_pass(acknowledges_nonsense)

    # As one that may not write the topic: the alert is not the broker's.
    def test_refuses_alerts(self):
        def behave(connection):
            while (packet := read_packet(connection)) is not None:
                kind, body = packet
                if kind >> 4 == 1:
                    connection.sendall(CONNACK_5)
                elif kind >> 4 == 3 and kind & 6:
                    length = int.from_bytes(body[:2], "big")
                    connection.sendall(b"\x40\x03" + body[2 + length:4 + length] + b"\x87")
        self.alerts_pass(behave)

    # QoS 1 messages that are not acknowledged: the broker is left after a while, and nothing is lost.
    def test_never_acknowledges(self):
        def behave(connection):
            while (packet := read_packet(connection)) is not None:
                if packet[0] >> 4 == 1:
                    connection.sendall(CONNACK_5)
                elif packet[0] >> 4 == 12:
                    connection.sendall(b"\xd0\x00")
        self.alerts_pass(behave)

    # A broker that accepts and then does not read: memory stays bounded, and slipd-mqtt leaves it.
    def test_never_reads(self):
        def behave(connection):
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            read_packet(connection)
            connection.sendall(CONNACK_5)
            time.sleep(60)
        hostile = HostileBroker(behave)
        bridge = self.bridge(hostile, rate_hz=1000)
        def resident():
            with open(f"/proc/{bridge.program.pid}/statm") as statm:
                return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        for _ in range(20_000):
            self.slipd.estimate("left")
        await_true(lambda: hostile.connections > 1, "the second attempt; " + bridge.log())
        if "asan" not in os.environ["SLIPD_BINARY_DIR"]:  # which keeps what was freed
            self.assertLess(resident(), 40e6)
        self.assertEqual(bridge.stop(), 0)

    def test_nobody_listens(self):
        gone = HostileBroker(closes_at_once)
        gone.listener.shutdown(socket.SHUT_RDWR)
        gone.listener.close()
        bridge = self.bridge(gone)
        self.slipd.alert("left")
        await_true(lambda: bridge.log().count("127.0.0.1") > 2, "three attempts; " + bridge.log())
        self.assertEqual(bridge.stop(), 0)

    # Numbers go on after a kill, and what was not acknowledged is sent by the next run.
    def test_alerts_survive_a_kill(self):
        published = []
        gone = HostileBroker(closes_at_once)
        bridge = self.bridge(gone)
        for _ in range(5):
            self.slipd.alert("left")
        await_true(lambda: '5 alerts wait' in self.waiting(bridge), "five alerts on disk")
        bridge.kill()
        friendly = HostileBroker(good(published))
        again = self.bridge(friendly)
        await_true(lambda: sum(topic.endswith("/alert") for topic, _ in published) >= 5, "the alerts; " + again.log())
        self.slipd.alert("left")
        await_true(lambda: any(b'"number":6,' in payload for _, payload in published), "the sixth; " + again.log())
        self.assertEqual(again.stop(), 0)

    def waiting(self, bridge):
        import sqlite3
        database = sqlite3.connect(bridge.settings.replace(".json", ".db"))
        try:
            return "%d alerts wait" % database.execute("SELECT count(*) FROM alerts").fetchone()[0]
        except sqlite3.OperationalError:
            return ""
        finally:
            database.close()


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # sockets of threads that end with the program
