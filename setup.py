"""Package belt_ros for pip and for colcon, which both read this file."""

from glob import glob

from setuptools import find_packages, setup

NAME = "belt_ros"

setup(
    name=NAME,
    version="0.1.0",
    description="Slip, tension and friction of a belt drive, estimated from pulley measurements",
    maintainer="The belt_ros maintainers",
    maintainer_email="maintainers@belt-ros.example.org",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", glob("config/*.yaml")),
        (f"share/{NAME}/launch", glob("launch_scripts/*.launch.py")),
    ],
    zip_safe=False,
    # ROS 2 itself (rclpy, the messages) comes with an installation, or as wheels: tools/.
    install_requires=[
        "filterpy>=2.0",
        "matplotlib",
        "mcap",
        "numba",
        "numpy",
        "pyarrow",
        "pyyaml",
        "rich",
        "rosbags",
        "scipy",
        "typer",
    ],
    extras_require={
        "dev": [
            "hypothesis",
            "import-linter",
            "mypy",
            "pytest",
            "pytest-timeout",
            "pytest-xdist",
            "ruff",
            "types-PyYAML",
        ],
    },
    entry_points={
        "console_scripts": [
            "belt = belt_ros.cli:main",
            "belt_node = belt_ros.node.main:main",
            "belt_rig = belt_ros.rig.main:main",
        ],
    },
)
