"""``npm install "$(python -m urdf_ik.export.web)"`` installs the npm module from this package."""

from pathlib import Path

if __name__ == "__main__":
    print(Path(__file__).resolve().parent)
