"""What README.md says of the code is what the code says."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()


def test_its_parameter_table_is_the_one_in_the_code() -> None:
    printed = subprocess.run(
        [sys.executable, "-m", "belt_ros.cli", "parameters", "--markdown"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    ).stdout.strip()
    written = README.split("<!-- parameters -->")[1].split("<!-- /parameters -->")[0].strip()
    assert written == printed


def test_every_file_it_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target
