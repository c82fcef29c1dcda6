"""``python -m urdf_ik.cmake`` prints the folder for CMake's ``urdf_ik_DIR``."""

from urdf_ik.cmake import core

if __name__ == "__main__":
    print(core() / "cmake")
