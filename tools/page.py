"""Bundles the script of `urdf-ik export --html`: src/urdf_ik/export/web/page.bundle.js, with three.js and its licence.

    python tools/page.py

Node and npm are needed; three.js and esbuild, at the versions of page/package.json, come from npm. The file is in no
repository, since it is mostly three.js and changes as a whole; a wheel that is built afterwards holds it.
"""

import gzip
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WEB = ROOT / "src" / "urdf_ik" / "export" / "web"
PLACE = ROOT / "build" / "page"
OUT = WEB / "page.bundle.js"


def main() -> None:
    """Install what is bundled, and bundle."""
    if shutil.which("npm") is None:
        sys.exit("npm is needed to bundle the page: apt install nodejs npm")
    PLACE.mkdir(parents=True, exist_ok=True)
    # Sources beside the packages, where they find them.
    shutil.copytree(
        WEB, PLACE, ignore=shutil.ignore_patterns("*.wasm", "*.bundle.js", "*.py", "__pycache__"), dirs_exist_ok=True
    )
    shutil.copy(WEB / "page" / "package.json", PLACE)
    subprocess.run(["npm", "install", "--silent", "--no-audit", "--no-fund"], cwd=PLACE, check=True)
    subprocess.run(
        ["node_modules/.bin/esbuild", "page/main.js", "--bundle", "--minify", "--format=iife", "--target=es2023",
         "--legal-comments=none", "--log-override:empty-import-meta=silent", "--external:node:fs/promises",
         "--log-level=warning", "--outfile=bundle.js"],
        cwd=PLACE, check=True,
    )  # fmt: skip
    licence = (PLACE / "node_modules" / "three" / "LICENSE").read_text().strip()
    text = f"/* This page holds three.js, https://threejs.org\n\n{licence}\n*/\n{(PLACE / 'bundle.js').read_text()}"
    OUT.write_text(text)
    packed = len(gzip.compress(text.encode(), 9, mtime=0))
    print(f"{OUT.relative_to(ROOT)}: {len(text) / 1e3:.0f} kB, {packed / 1e3:.0f} kB gzipped")


if __name__ == "__main__":
    main()
