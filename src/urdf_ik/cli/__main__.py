"""``python -m urdf_ik.cli`` is the ``urdf-ik`` command."""

from urdf_ik.cli.application import main

if __name__ == "__main__":
    main()
