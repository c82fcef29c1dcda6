"""``python -m urdf_ik.cli`` is the ``urdf-ik`` command."""

from urdf_ik.cli import main

if __name__ == "__main__":
    main()
