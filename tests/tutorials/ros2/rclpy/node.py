import os, subprocess, sys, time


class Logger:
    def __init__(self, node):
        self.node = node

    def info(self, text):
        print(f"[INFO] [{time.time():.9f}] [{self.node}]: {text}", flush=True)


class Node:
    def __init__(self, name):
        self.logger, self.subscriptions = Logger(name), {}

    def get_logger(self):
        return self.logger

    def create_subscription(self, kind, topic, callback, depth):
        assert depth == 10, "the reader's depth, and rclcpp's default"
        self.subscriptions[topic] = (kind, callback)

    def spin(self):
        """Calls back for each message until its reader ends."""
        words = [word for topic, (kind, _) in self.subscriptions.items() for word in (topic, kind.DDS_NAME)]
        reader = [os.path.join(os.environ["SLIPD_BINARY_DIR"], "test-bin", "fastdds-reader"), "loopback", os.environ["ROS_DOMAIN_ID"], "0", *words]
        with subprocess.Popen(reader, stdout=subprocess.PIPE, text=True) as reading:
            for line in reading.stdout:
                topic, _, _, payload = line.split(" ")
                kind, callback = self.subscriptions[topic]
                callback(kind.of(bytes.fromhex(payload)))
        sys.exit(reading.returncode)
