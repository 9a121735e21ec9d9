"""RViz with the taxels of one sensor: ros2 launch slipd_msgs view.launch.py sensor:=left

slipd-ros2 runs as a service or by hand; this starts no bridge. The sensor's frame is shown at the origin; a robot's own description
replaces the static transform."""
import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    layout = os.path.join(get_package_share_directory("slipd_msgs"), "layouts", "taxels.rviz")
    sensor = LaunchConfiguration("sensor")
    return LaunchDescription([
        DeclareLaunchArgument("sensor", default_value="left"),
        Node(package="tf2_ros", executable="static_transform_publisher",
             arguments=["--frame-id", "world", "--child-frame-id", sensor]),
        Node(package="rviz2", executable="rviz2", arguments=["-d", layout],
             remappings=[("/slipd/left/taxels", ["/slipd/", sensor, "/taxels"])]),
    ])
