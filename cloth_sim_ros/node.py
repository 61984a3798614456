"""``cloth_node``: the executable. ROS, and the solver, are imported only when signals can be answered."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from cloth_sim_ros.command_line import complain, end_at_once_on_signals, split_ros_args

DESCRIPTION = """\
Real-time cloth on ROS 2 topics. Starts the managed node /cloth_sim, which configures and
activates itself: it simulates a scene, listens to grippers, wind and obstacles, publishes the
cloth, and records a session that cloth_replay can show and verify."""

EPILOG = """\
scenes (parameter scene: one of these names, or the path of a scene file):
  {scenes}

topics and services (relative to the node; <name> as declared in the scene):
{interfaces}

examples:
  cloth_node --ros-args -p scene:=flag
  cloth_node --ros-args -p scene:=$HOME/my.yaml -p record:=all -p material.friction:=0.5
  cloth_node --ros-args --params-file cloth.yaml -r __ns:=/lab -r '~/wind:=/weather/wind'
  ros2 topic pub -r 50 /cloth_sim/wind geometry_msgs/msg/Vector3Stamped '{{vector: {{x: 3.0}}}}'
  ros2 service call /cloth_sim/pause std_srvs/srv/SetBool '{{data: true}}'

parameters: every one, with default, range and unit, is in
  {parameters}

Exit code 0 after Ctrl-C, 1 if the node cannot start."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit code."""
    end_at_once_on_signals()
    arguments, ros_arguments = split_ros_args(sys.argv[1:] if argv is None else argv)
    if arguments:
        _parser().parse_args(arguments)
    try:
        from cloth_sim_ros.ros.process import run

        return run(ros_arguments)
    except ImportError as error:
        complain("cloth_node", f"{error}: source a ROS 2 installation, or pip install 'cloth_sim_ros[ros]'")
        return 1


def _parser() -> argparse.ArgumentParser:
    from cloth_sim_ros import interfaces, share

    epilog = EPILOG.format(
        scenes=", ".join(share.scene_names()),
        interfaces=interfaces.as_text(),
        parameters=share.share_folder() / "config" / "cloth.yaml",
    )
    return argparse.ArgumentParser(
        prog="cloth_node",
        description=DESCRIPTION,
        epilog=epilog,
        usage="cloth_node [-h] [--ros-args ...]",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


if __name__ == "__main__":
    sys.exit(main())
