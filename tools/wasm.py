"""Builds the core as WebAssembly: src/urdf_ik/export/web/urdf_ik.wasm, which solves any compiled arm.

    python tools/wasm.py

The compiler is Zig's from PyPI, installed into this Python's environment where it is missing. What changed since the
last build is compiled anew. The file is in no repository; a wheel that is built afterwards holds it.
"""

import gzip
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from with_compiler import ROOT, zig

CORE = ROOT / "src" / "core"
PLACE = ROOT / "build" / "wasm"
OUT = ROOT / "src" / "urdf_ik" / "export" / "web" / "urdf_ik.wasm"
TARGET = ("-target", "wasm32-wasi")
# The arithmetic is that of x86-64-v2: two doubles in a register, nothing fused. So are its answers.
FLAGS = (
    *TARGET, "-std=c++20", "-O3", "-g0", "-msimd128", "-fexceptions", "-fno-math-errno", "-ffp-contract=fast",
    "-fno-trapping-math", "-DURDF_IK_LEVEL=v2", "-DURDF_IK_BUILT_V2", f"-I{CORE}", "-Wall", "-Wextra",
)  # fmt: skip
# 1 MiB of stack: the deepest solver takes 33 kB, the reader of JSON a call a level.
LINK = (*TARGET, "-mexec-model=reactor", "-Wl,-z,stack-size=1048576", "-Wl,--strip-all", "-O3")
EXPORTS = (
    "malloc", "free", "urdf_ik_parse", "urdf_ik_solve", "urdf_ik_fk", "urdf_ik_jacobian", "urdf_ik_redundancy_of",
    "urdf_ik_turns", "urdf_ik_compiled_from",
)  # fmt: skip


def sources() -> list[Path]:
    """The sources that src/core/core.cmake lists, and the one for WebAssembly."""
    lists = re.findall(
        r"^set\(URDF_IK_(?:UNITS|ARMS|LIBRARY)\n(.*?)^\)", (CORE / "core.cmake").read_text(), re.M | re.S
    )
    return [CORE / name for text in lists for name in text.split()] + [CORE / "library" / "web.cpp"]


def outdated(source: Path) -> bool:
    """Whether a source, or a file that it included, is newer than its object."""
    made, needs = object_of(source), object_of(source).with_suffix(".d")
    if not made.is_file() or not needs.is_file():
        return True
    names = needs.read_text().replace("\\\n", " ").split(":", 1)[1].split()
    built = made.stat().st_mtime
    return any(not Path(name).is_file() or Path(name).stat().st_mtime > built for name in (*names, __file__))


def object_of(source: Path) -> Path:
    """Where a source is compiled to."""
    return PLACE / (str(source.relative_to(CORE)).replace("/", "_") + ".o")


def compiled(source: Path) -> int:
    """Compile one source; the compiler's exit code."""
    made = object_of(source)
    return subprocess.run(
        [zig(), "c++", *FLAGS, "-MD", "-MF", made.with_suffix(".d"), "-c", source, "-o", made], check=False
    ).returncode


def main() -> None:
    """Compile what changed, and link."""
    zig()
    PLACE.mkdir(parents=True, exist_ok=True)
    waiting = [source for source in sources() if outdated(source)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        if any(pool.map(compiled, waiting)):
            sys.exit("the core does not compile to WebAssembly")
    exports = [f"-Wl,--export={name}" for name in EXPORTS]
    objects = [object_of(source) for source in sources()]
    if subprocess.run([zig(), "c++", *LINK, *exports, *objects, "-o", OUT], check=False).returncode:
        sys.exit("the objects in build/wasm do not link")
    data = OUT.read_bytes()
    packed = len(gzip.compress(data, 9, mtime=0))
    print(f"{OUT.relative_to(ROOT)}: {len(data) / 1e3:.0f} kB, {packed / 1e3:.0f} kB gzipped")


if __name__ == "__main__":
    main()
