"""How pip and colcon install the two packages: the solver, and the ROS 2 package around it."""

from __future__ import annotations

from pathlib import Path

from setuptools import find_packages, setup

NAME = "cloth_sim_ros"
HERE = Path(__file__).resolve().parent

WHEELS_EXIST = "sys_platform == 'linux' and platform_machine == 'x86_64'"

REQUIRED = [
    "numpy>=1.26",  # every array
    "scipy>=1.11",  # sparse matrices, graphs
    "numba>=0.58",  # compiles the kernels
    f"tbb>=2021.6; {WHEELS_EXIST}",  # shares loops of the kernels among threads
    "trimesh>=4.0",  # reads triangle meshes, answers whether one is watertight
    "ruamel.yaml>=0.18",  # reads scenes as YAML 1.2 and knows the line of a wrong key
    "mcap>=1.5",  # writes and reads sessions
    "lz4>=4.3",  # compresses them
]

EXTRAS = {
    "ros": [  # for machines without ROS 2; where a distribution is installed, its own rclpy serves
        f"ros-jazzy-rclpy; {WHEELS_EXIST}",  # nodes; brings lifecycle_msgs, rosgraph_msgs, ament_index_python
        f"ros-jazzy-common-interfaces; {WHEELS_EXIST}",  # the other messages, std_srvs among them
        f"ros-jazzy-rmw-fastrtps-cpp; {WHEELS_EXIST}",  # the middleware, Fast DDS
    ],
    "render": [
        "pyvista>=0.43",  # draws scenes without a display
        "pillow>=10.0",  # writes and labels PNG files
        "imageio>=2.31",  # writes animations
        "imageio-ffmpeg>=0.4.9",  # the encoder of the animations
    ],
    "bench": ["matplotlib>=3.7"],  # draws the benchmarks
    "test": [
        "pytest>=7.4",  # runs the tests
        "pytest-xdist>=3.5",  # in two processes at once
        "hypothesis>=6.80",  # invents the inputs of property tests
        "rosbags>=0.10",  # a foreign reader for our sessions
        "import-linter>=2.15",  # keeps ROS out of the solver
        "ruff>=0.6",  # style
    ],
}

COMMANDS = {
    "cloth_node": "cloth_sim_ros.node:main",
    "cloth_operator": "cloth_sim_ros.operator:main",
    "cloth_run": "cloth_sim_ros.run:main",
    "cloth_replay": "cloth_sim_ros.replay:main",
    "cloth_render": "cloth_sim_ros.render:main",
    "cloth_validate": "cloth_core.validation.cli:main",
}


def files_under(folder: str) -> list[tuple[str, list[str]]]:
    """Lists what a folder of the checkout puts into the package's share folder, sub-folders kept."""
    files: dict[str, list[str]] = {}
    for path in sorted((HERE / folder).rglob("*")):
        if path.is_file() and path.suffix != ".pyc":
            relative = path.relative_to(HERE)
            files.setdefault(f"share/{NAME}/{relative.parent.as_posix()}", []).append(relative.as_posix())
    return list(files.items())


setup(
    name=NAME,
    version="0.1.0",
    description="Interactive cloth simulation for ROS 2, after Meyer, Debunne, Desbrun and Barr",
    license="Apache-2.0",
    maintainer="cloth_sim_ros maintainers",
    maintainer_email="maintainers@example.com",
    python_requires=">=3.10",
    packages=find_packages(include=["cloth_core*", "cloth_sim_ros*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *files_under("config"),
        *files_under("launch"),
    ],
    install_requires=REQUIRED,
    extras_require=EXTRAS,
    entry_points={"console_scripts": [f"{command} = {target}" for command, target in COMMANDS.items()]},
    zip_safe=False,
)
