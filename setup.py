"""Package belt_ros for pip and for colcon, which both read this file."""

import os
from glob import glob

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

NAME = "belt_ros"
MESSAGES = "msg_defs/msg"


class BuildWithMessages(build_py):
    """Put the definitions of the messages beside the modules: bags are read without ROS."""

    def _copies(self):
        place = os.path.join(self.build_lib, NAME, "message_texts")
        # An editable installation reads the checkout's. Humble's setuptools knows no such mode.
        editable = getattr(self, "editable_mode", False)
        sources = [] if editable else sorted(glob(f"{MESSAGES}/*.msg"))
        return [(source, os.path.join(place, os.path.basename(source))) for source in sources]

    def run(self):
        """Build as always, then copy."""
        super().run()
        for source, copy in self._copies():
            self.mkpath(os.path.dirname(copy))
            self.copy_file(source, copy, preserve_mode=False)

    def get_outputs(self, *arguments, **options):
        """Name the copies too, for what keeps records of them."""
        return [*super().get_outputs(*arguments, **options), *(copy for _, copy in self._copies())]


setup(
    name=NAME,
    version="0.1.0",
    description="Slip, tension and friction of a belt drive, estimated from pulley measurements",
    maintainer="The belt_ros maintainers",
    maintainer_email="maintainers@belt-ros.example.org",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"], f"{NAME}.report": ["assets/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/config", glob("config/*.yaml")),
        (f"share/{NAME}/config/scenarios", glob("config/scenarios/*.yaml")),
        (f"share/{NAME}/launch", glob("launch_scripts/*.launch.py")),
    ],
    cmdclass={"build_py": BuildWithMessages},
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
            "pytest-xdist>=3.8",
            "ruff",
            "selenium",
            "dask",
            "distributed",
            "types-PyYAML",
        ],
        "fleet": ["dask", "distributed"],  # for `belt fleet --scheduler`
        "exudyn": ["exudyn==1.13.*"],  # a peer for benchmarks/mechanics
    },
    entry_points={
        "console_scripts": [
            "belt = belt_ros.cli:main",
            "belt_node = belt_ros.node.main:main",
            "belt_rig = belt_ros.rig.main:main",
        ],
    },
)
