"""As much of ROS 2's rclpy as the node of docs/tutorials/ros2.md uses, in place of the real one, which Debian does not have: what it reads comes
by Fast DDS, the library behind ROS 2's default middleware, with rclcpp's default quality of service (fastdds-reader)."""


def init():
    """The node connects when it spins."""


def spin(node):
    node.spin()
