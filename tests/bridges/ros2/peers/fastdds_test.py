"""Topics of slipd-ros2, read by Fast DDS with rclcpp's default QoS: the user data has the type's hash, the values are slipd's."""
import math, os, struct, subprocess, unittest

from awaiting import PATIENCE_S
from mcap_test import BRIDGE, BUILD, STATE_DISCONNECTED, Programs

TOPICS = {"margin": ("std_msgs::msg::dds_::Float32_", "7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2"),
          "wrench": ("geometry_msgs::msg::dds_::WrenchStamped_", "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"),
          "taxels": ("sensor_msgs::msg::dds_::PointCloud2_", "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"),
          "estimate": ("slipd_msgs::msg::dds_::SlipEstimate_", None)}


class FastDds(Programs):
    def test_it_reads_each_topic_of_a_sensor(self):
        domain = str(1 + os.getpid() % 100)
        self.write("ros2.json", {"socket": self.socket, "domain": int(domain)})
        self.start(BRIDGE, "--config", self.path("ros2.json"))
        words = [word for leaf, (kind, _) in TOPICS.items() for word in (f"/slipd/left/{leaf}", kind)]
        words += ["/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_"]
        reader = os.path.join(BUILD, "test-bin", "fastdds-reader")
        out = subprocess.run([reader, "loopback", domain, "3", *words], capture_output=True, text=True, timeout=PATIENCE_S, check=True).stdout
        of = {}
        for line in out.splitlines():
            topic, user_data, _, payload = line.split(" ")
            of.setdefault(topic, []).append((user_data, bytes.fromhex(payload)))
        for leaf, (_, digest) in TOPICS.items():
            for user_data, _ in of[f"/slipd/left/{leaf}"]:
                self.assertRegex(user_data, f"^typehash=RIHS01_{digest or '[0-9a-f]{64}'};$")
        for _, payload in of["/slipd/left/margin"]:
            self.assertEqual(payload[:2], b"\0\1")
            margin, = struct.unpack_from("<f", payload, 4)
            self.assertTrue(math.isnan(margin) or 0 <= margin <= 1)
        for _, payload in of["/slipd/left/estimate"]:
            self.compare_estimate(payload)

    def compare_estimate(self, payload):
        """Stamp, "left" twice, state: a margin in state ok only."""
        body = payload[4:]
        self.assertEqual(struct.unpack_from("<I5s", body, 8), (5, b"left\0"))
        self.assertEqual(struct.unpack_from("<I5s", body, 20), (5, b"left\0"))
        state = body[29]
        self.assertLess(state, STATE_DISCONNECTED)
        margin, = struct.unpack_from("<d", body, 64)
        self.assertEqual(math.isnan(margin), state != 0)


if __name__ == "__main__":
    unittest.main()
