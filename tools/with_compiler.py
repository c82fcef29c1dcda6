"""Runs a command with a C++20 compiler: the machine's, or Zig's from PyPI where the machine has none.

    python tools/with_compiler.py python -m pip install --no-build-isolation --editable .

The compiler is $CXX, c++, g++ or clang++, the first that compiles what the core needs. Where none does, `ziglang` is
installed into this Python's environment, with small scripts that call it as c++, ar and ranlib; CXX, AR and RANLIB name
them to the command. Programs of this Python's environment (cmake, ninja) are on the command's path.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WANTED = "a C++20 compiler is needed (GCC 12, Clang 15 or later): apt install g++, or CXX=... names one"
ZIG = "ziglang>=0.14"
# What old compilers lack: C++20, shuffles of vectors, the standard library's headers.
PROBE = """
#include <concepts>
#include <vector>
typedef double Two __attribute__((vector_size(16)));
template <std::floating_point T> Two swapped(Two a) { return __builtin_shufflevector(a, a, 1, 0); }
int main() { return int(swapped<double>(Two{0, 1})[1]) + int(std::vector<int>().size()); }
"""


def compiles(compiler: str) -> bool:
    """Whether a compiler is there and compiles, and links, what the core needs."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "probe.cpp")
        source.write_text(PROBE)
        try:
            command = [*compiler.split(), "-std=c++20", str(source), "-o", str(Path(folder, "probe"))]
            return subprocess.run(command, capture_output=True, check=False).returncode == 0
        except OSError:
            return False


def zig() -> Path:
    """Zig's program in this environment, installed from PyPI where it is missing."""
    if importlib.util.find_spec("ziglang") is None:
        print("no C++20 compiler on this machine: installing Zig's from PyPI (100 MB)", file=sys.stderr)
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", ZIG]
        if subprocess.run(pip, check=False).returncode:
            sys.exit(f"{WANTED}; {ZIG} from PyPI could not be installed either")
        importlib.invalidate_caches()
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        sys.exit(f"{WANTED}; {ZIG} from PyPI could not be installed either")
    return Path(spec.origin).with_name("zig")


def zig_scripts() -> dict[str, str]:
    """Scripts that call Zig by the names of a compiler's programs."""
    program, folder = zig(), Path(sys.prefix, "zig")
    folder.mkdir(exist_ok=True)
    found = {}
    for variable, name in {"CXX": "c++", "CC": "cc", "AR": "ar", "RANLIB": "ranlib"}.items():
        script = folder / name
        script.write_text(f'#!/bin/sh\nexec "{program}" {name} "$@"\n')
        script.chmod(0o755)
        found[variable] = str(script)
    if not compiles(found["CXX"]):
        sys.exit(f"{WANTED}; Zig's, {program}, does not work here")
    return found


def environment() -> dict[str, str]:
    """The environment of a command that compiles."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    env = os.environ | {"PATH": path}
    named = os.environ.get("CXX")
    if named:
        if not compiles(named):
            sys.exit(f"{WANTED}; CXX={named} does not compile what the core needs")
        return env
    for name in ("c++", "g++", "clang++"):
        if (compiler := shutil.which(name)) and compiles(compiler):
            return env | {"CXX": compiler}
    return env | zig_scripts()


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(subprocess.run(sys.argv[1:], env=environment(), check=False).returncode)
