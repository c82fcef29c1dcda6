"""Arms as one file on an emulated Cortex-M7: sizes, counts and stack, as a table.

    python tools/cortex_m7.py [--poses 100] [--optimise=-O2] [ARM ...]

A third of the poses is random, a third has joints at multiples of 45 degrees, a third is singular. The status is 1
where a count differs from that of this machine. Debian's packages are gcc-arm-none-eabi, libnewlib-arm-none-eabi,
libstdc++-arm-none-eabi-newlib (headers) and qemu-system-arm.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import urdf_ik
from urdf_ik import export

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

from arms_outside import GENERAL, poses_of  # noqa: E402

HERE = ROOT / "tools" / "cortex_m7"
ARMS = ("planar_2r", "scara_rrpr", "zyyzyz_6r", "srs_7r", "rail_6r", GENERAL)
COMPILER, EMULATOR = "arm-none-eabi-g++", "qemu-system-arm"
FLAGS = (
    "-std=c++20", "-ffreestanding", "-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics", "-ffunction-sections",
    "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-Wall", "-Wextra", "-Werror",
    "-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-nostartfiles", "--specs=nosys.specs",
    "-Wl,--gc-sections", f"-Wl,-T,{HERE / 'mps2.ld'}", "-Wl,--no-warnings",
)  # fmt: skip
BOARD = ("-M", "mps2-an500", "-cpu", "cortex-m7", "-nographic", "-semihosting", "-monitor", "none", "-serial", "null")


def measured(arm: urdf_ik.Arm, many: int, optimise: str) -> tuple[int, int, int, int, int]:
    """Code and constants [bytes], poses with the same count, poses, solutions, and stack [bytes]."""
    T = poses_of(arm, many)
    counts = ", ".join(str(int(n)) for n in arm.ik(T).valid.sum(axis=-1))
    rows = ",\n".join("{" + ", ".join(repr(float(x)) for x in row) + "}" for row in T.reshape(-1, 16))
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        place.joinpath("arm.hpp").write_text(export.cpp(arm, "arm"))
        place.joinpath("poses.hpp").write_text(
            f"inline constexpr int POSES = {len(T)};\nstatic const double poses[][16] = {{{rows}}};\n"
            f"static const int counts[] = {{{counts}}};\n"
        )
        program = place / "program.elf"
        _run(COMPILER, *FLAGS, optimise, f"-I{folder}", str(HERE / "main.cpp"), "-o", str(program))
        code = int(_run("arm-none-eabi-size", str(program)).splitlines()[1].split()[0]) - (128 + 4) * len(T)
        said = _run(EMULATOR, *BOARD, "-kernel", str(program))
    try:
        same, poses, solutions, stack = (int(word) for word in said.split())
    except ValueError:
        sys.exit(f"{arm.name}: the program says {said!r}")
    return code, same, poses, solutions, stack


def _run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout + (done.stderr if command[0] == EMULATOR else "")


def main() -> None:
    """Print a row for each arm."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("arms", nargs="*", default=ARMS)
    parser.add_argument("--poses", type=int, default=100)
    parser.add_argument("--optimise", default="-O2")
    given = parser.parse_args()
    if missing := [program for program in (COMPILER, EMULATOR) if shutil.which(program) is None]:
        sys.exit(
            f"{' and '.join(missing)} not found; Debian: gcc-arm-none-eabi libnewlib-arm-none-eabi "
            f"libstdc++-arm-none-eabi-newlib {EMULATOR}"
        )
    print("| arm | code and constants [kB] | poses with the same count | solutions | stack [kB] |")
    print("|---|---|---|---|---|")
    differ = False
    for name in given.arms:
        arm = urdf_ik.load(name)
        code, same, poses, solutions, stack = measured(arm, given.poses, given.optimise)
        print(f"| {arm.name} | {code / 1e3:.0f} | {same} of {poses} | {solutions} | {stack / 1e3:.1f} |", flush=True)
        differ |= same != poses
    sys.exit(differ)


if __name__ == "__main__":
    main()
