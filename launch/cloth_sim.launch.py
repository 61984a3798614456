"""Starts the cloth node: ros2 launch cloth_sim_ros cloth_sim.launch.py scene:=flag namespace:=lab."""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {  # name: default, description
    "scene": ("scarf", "name of an installed scene, or a path"),
    "params_file": ("", "YAML file of node parameters; none if empty"),
    "namespace": ("", "namespace of the node and its topics"),
    "use_sim_time": ("false", "step with /clock instead of the computer's clock"),
    "log_level": ("info", "debug, info, warn, error or fatal"),
}


def cloth_node(context: LaunchContext) -> list[Node]:
    """Describes the node; parameters named in the launch arguments outrank the file."""
    params_file = LaunchConfiguration("params_file").perform(context)
    arguments = {
        "scene": ParameterValue(LaunchConfiguration("scene"), value_type=str),
        "use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool),
    }
    node = Node(
        package="cloth_sim_ros",
        executable="cloth_node",
        name="cloth_sim",
        namespace=LaunchConfiguration("namespace"),
        parameters=[params_file, arguments] if params_file else [arguments],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
        emulate_tty=True,
    )
    return [node]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=cloth_node)])
