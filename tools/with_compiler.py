"""Runs a command with a C++20 compiler: the machine's, or Zig's from PyPI where the machine has none.

    python tools/with_compiler.py [--here | --each] python -m pip install --no-build-isolation --editable .

The compiler is $CXX, c++, g++ or clang++, the first that compiles what the core needs. Where none does, `ziglang` is
installed into this Python's environment, with small scripts that call it as c++, ar and ranlib; CXX, AR and RANLIB name
them to the command. Programs of this Python's environment (cmake, ninja) are on the command's path.

With --here a core that was not built before is built for this machine's processor only, one instruction set of three,
and without what only tests use. With --each it is built for every instruction set, but by Zig, which takes minutes for
a solver, for this one. CMAKE_ARGS that name instruction sets come first.
"""

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WANTED = "a C++20 compiler is needed (GCC 12, Clang 15 or later): apt install g++, or CXX=... names one"
ZIG = "ziglang>=0.14"
LEVELS = ("v2", "v3", "v4")
ROOT = Path(__file__).resolve().parents[1]
# What old compilers lack: C++20, shuffles of vectors, the standard library's headers.
PROBE = """
#include <concepts>
#include <vector>
typedef double Two __attribute__((vector_size(16)));
template <std::floating_point T> Two swapped(Two a) { return __builtin_shufflevector(a, a, 1, 0); }
int main() { return int(swapped<double>(Two{0, 1})[1]) + int(std::vector<int>().size()); }
"""


def compiles(compiler: str) -> bool:
    """Whether a compiler is there and compiles what the core needs."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "probe.cpp")
        source.write_text(PROBE)
        try:
            command = [*compiler.split(), "-std=c++20", "-O3", "-c", str(source), "-o", str(Path(folder, "probe.o"))]
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


def this_level() -> str:
    """The x86-64 level of this machine's processor, the highest that the core is built for."""
    flags: set[str] = set()
    if (known := Path("/proc/cpuinfo")).is_file():
        flags = {flag for line in known.read_text().splitlines() if line.startswith("flags") for flag in line.split()}
    if not {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"} <= flags:
        return "v2"
    return "v4" if {f"avx512{part}" for part in ("f", "bw", "cd", "dq", "vl")} <= flags else "v3"


def with_levels(env: dict[str, str], levels: str) -> dict[str, str]:
    """The environment with the instruction sets that are to be built, unless it names some."""
    given = env.get("CMAKE_ARGS", "")
    if platform.machine() not in ("x86_64", "AMD64") or "URDF_IK_LEVELS" in given:
        return env
    return env | {"CMAKE_ARGS": f"{given} -DURDF_IK_LEVELS={levels}".strip()}


def with_argument(env: dict[str, str], argument: str) -> dict[str, str]:
    """The environment with one more argument for CMake about what only tests use, unless it has one."""
    given = env.get("CMAKE_ARGS", "")
    return env if "URDF_IK_TESTS" in given else env | {"CMAKE_ARGS": f"{given} {argument}".strip()}


def environment(mode: str) -> dict[str, str]:
    """The environment of a command that compiles; ``mode``: '--here', '--each' or ''."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    env = os.environ | {"PATH": path}
    named, is_zig = os.environ.get("CXX"), False
    if named:
        if not compiles(named):
            sys.exit(f"{WANTED}; CXX={named} does not compile what the core needs")
    else:
        candidates = filter(None, map(shutil.which, ("c++", "g++", "clang++")))
        found = next(filter(compiles, candidates), None)
        is_zig = found is None
        env |= zig_scripts() if found is None else {"CXX": found}
    if mode == "--each":
        # CMake forgets what --here left in its cache: an editable install builds what tests use, a wheel does not.
        levels = this_level() if is_zig else ";".join(LEVELS)
        return with_argument(with_levels(env, levels), "-UURDF_IK_TESTS")
    built = any(ROOT.glob("build/cp*/CMakeCache.txt"))
    if mode != "--here" or built:
        return env
    return with_argument(with_levels(env, this_level()), "-DURDF_IK_TESTS=OFF")


if __name__ == "__main__":
    mode = sys.argv[1] if sys.argv[1:2] in (["--here"], ["--each"]) else ""
    wanted = sys.argv[2:] if mode else sys.argv[1:]
    if not wanted:
        sys.exit(__doc__)
    sys.exit(subprocess.run(wanted, env=environment(mode), check=False).returncode)
