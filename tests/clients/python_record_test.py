"""Client.record of the Python module against a stand-in for slipd, which passes a descriptor to read the recording from."""
import os, sys, tempfile, threading, unittest

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "support"))
from awaiting import PATIENCE_S, await_true
from fake_slipd import FakeSlipd, Server
import slipd


class Recordings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        server = Server()
        self.addCleanup(server.close)
        self.slipd = FakeSlipd(os.path.join(folder.name, "socket"), ["left"], server)
        self.addCleanup(self.slipd.close)
        self.path = os.path.join(folder.name, "left.rec")
        self.client = slipd.Client(self.slipd.path, timeout_s=PATIENCE_S)

    def record(self, serve):
        """What record() returns or raises while `serve` is slipd."""
        result = []

        def run():
            try:
                result.append(self.client.record("left", 0.5, self.path))
            except Exception as error:
                result.append(error)

        caller = threading.Thread(target=run)
        caller.start()
        await_true(lambda: self.slipd.recordings, "the request")
        serve()
        caller.join()
        return result[0]

    def content(self):
        with open(self.path, "rb") as file:
            return file.read()

    def test_the_file_has_what_slipd_passes_and_the_result_is_what_slipd_says_at_the_end(self):
        frames = bytes(range(256)) * 4096  # more than a socket holds
        told = self.record(lambda: self.slipd.recorded(0, frames))
        self.assertEqual((told["recording"], told["sensor"], told["frames"], told["bytes"], told["trouble"]), (1, "left", 2, len(frames), None))
        self.assertEqual(self.content(), frames)

    def test_a_recording_that_ended_early_is_an_error_and_what_came_is_kept(self):
        told = self.record(lambda: self.slipd.recorded(0, b"begun", "2 frames were written: the sensor is gone"))
        self.assertIsInstance(told, slipd.SlipdError)
        self.assertEqual(str(told), "2 frames were written: the sensor is gone")
        self.assertEqual(self.content(), b"begun")

    def test_a_slipd_that_dies_meanwhile_is_told_and_what_came_is_kept(self):
        def die():
            client, frames = self.slipd.recordings[0]
            frames.sendall(b"begun")
            self.slipd.server.remove(client["socket"])
            frames.close()

        self.assertIsInstance(self.record(die), slipd.Disconnected)
        self.assertEqual(self.content(), b"begun")

    def test_a_refusal_leaves_no_file(self):
        self.client.path += ".none"
        with self.assertRaises(slipd.Disconnected):
            self.client.record("left", 0.5, self.path)
        self.assertFalse(os.path.exists(self.path))

    def test_a_file_that_exists_is_not_overwritten(self):
        with open(self.path, "wb") as file:
            file.write(b"dear")
        with self.assertRaises(FileExistsError):
            self.client.record("left", 0.5, self.path)
        self.assertEqual(self.content(), b"dear")
        self.assertEqual(self.slipd.recordings, [])


if __name__ == "__main__":
    unittest.main()
