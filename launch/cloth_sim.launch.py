"""Starts the cloth node: ros2 launch cloth_sim_ros cloth_sim.launch.py scene:=flag namespace:=lab rviz:=true."""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {  # name: default, description
    "scene": ("", "name of an installed scene, or a path; if empty, what params_file says, or scarf"),
    "params_file": ("", "YAML file of node parameters; none if empty"),
    "name": ("cloth_sim", "name of the node"),
    "namespace": ("", "namespace of the node and its topics"),
    "record": ("", "what the session holds: none, inputs, outputs or all; if empty, as scene"),
    "use_sim_time": ("false", "step with /clock instead of the computer's clock"),
    "operator": ("false", "play the scene's script over topics, as a person would"),
    "rviz": ("false", "open RViz with the package's layout (for the names /cloth_sim and world)"),
    "log_level": ("info", "debug, info, warn, error or fatal"),
}


def cloth_node(context: LaunchContext) -> list[Node]:
    """Describes the node; launch arguments that are given outrank the file."""
    params_file = LaunchConfiguration("params_file").perform(context)
    given = {name: LaunchConfiguration(name).perform(context) for name in ("scene", "record")}
    arguments = {name: ParameterValue(text, value_type=str) for name, text in given.items() if text}
    arguments["use_sim_time"] = ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)
    node = Node(
        package="cloth_sim_ros",
        executable="cloth_node",
        name=LaunchConfiguration("name"),
        namespace=LaunchConfiguration("namespace"),
        parameters=[params_file, arguments] if params_file else [arguments],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
        emulate_tty=True,
    )
    return [node]


def operator(context: LaunchContext) -> list[Node]:
    """Describes the scripted operator of that node."""
    namespace = LaunchConfiguration("namespace").perform(context).strip("/")
    name = LaunchConfiguration("name").perform(context)
    node = f"/{namespace}/{name}" if namespace else f"/{name}"
    return [
        Node(
            package="cloth_sim_ros",
            executable="cloth_operator",
            arguments=["--scene", LaunchConfiguration("scene").perform(context) or "scarf", "--namespace", node],
            condition=IfCondition(LaunchConfiguration("operator")),
        )
    ]


def rviz() -> Node:
    """Describes RViz with the layout of the package."""
    return Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", PathJoinSubstitution([FindPackageShare("cloth_sim_ros"), "config", "cloth.rviz"])],
        condition=IfCondition(LaunchConfiguration("rviz")),
    )


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` asks for."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    parts = [OpaqueFunction(function=cloth_node), OpaqueFunction(function=operator), rviz()]
    return LaunchDescription([*arguments, *parts])
