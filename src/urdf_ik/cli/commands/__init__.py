"""What the commands of ``urdf-ik`` do, one file each."""
