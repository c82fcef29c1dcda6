"""check_urdf, the reader of URDFs that ROS ships."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def run_check_urdf(path: Path) -> subprocess.CompletedProcess[str]:
    """Run check_urdf, which comes with Pinocchio's wheels or with Debian's liburdfdom-tools."""
    folders = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    command = shutil.which("check_urdf", path=folders)
    if command is None:
        pytest.skip("check_urdf is not installed: neither Pinocchio's wheel nor liburdfdom-tools is here")
    return subprocess.run([command, str(path)], capture_output=True, text=True, timeout=60, check=False)
