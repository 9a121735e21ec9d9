"""What tests of the programs slipd-feed and slipd-feed-ros2 have in common: messages go in, and the real slipd says the margin or none."""
import os, sys, time

from awaiting import await_true

sys.path.insert(0, os.path.join(os.environ["SLIPD_SOURCE_DIR"], "tests", "clients"))
from push_test import NOTHING, RATE_HZ, contact  # contacts of Cattaneo and Mindlin, in Pa

OLD_S = 3600
MARGIN_ERROR = 0.1  # of single frames by `moments`, on taxels a tenth of the radius wide


class MarginsOfMessages:
    """`frame_message(frame)` makes the next message, `send(message)` sends it; `client` is slipd's, of the sensor left."""

    def estimate(self):
        return self.client.gamma("left", max_age_s=OLD_S)

    def send_until(self, frame, condition, what):
        """Sends messages of the frame at the sensor's rate until the sensor's estimate is so; returns it."""
        def sent():
            self.send(self.frame_message(frame))
            time.sleep(1 / RATE_HZ)
            estimate = self.estimate()
            return estimate if condition(estimate) else None
        return await_true(sent, what)

    def hold(self, pull=0.3):
        """The margin of this contact, when slipd says it."""
        self.send_until(NOTHING, lambda each: each.state == "no_contact", "the zero")
        return self.send_until(contact(1, pull), lambda each: each.gamma is not None and abs(each.gamma - (1 - pull)) < MARGIN_ERROR,
                               f"the margin {1 - pull}")

    def never_a_margin(self, messages):
        """None of these messages gives a margin once slipd has heard nothing for a second."""
        await_true(lambda: self.estimate().state == "fault", "a fault")
        for number, message in enumerate(messages):
            self.send(message)
            time.sleep(1 / RATE_HZ)
            estimate = self.estimate()
            self.assertEqual((estimate.gamma, estimate.state), (None, "fault"), number)
