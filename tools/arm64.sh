#!/usr/bin/env bash
# Builds and tests the core for arm64 on an x86-64 Debian, as root, with a network that reaches PyPI and apt.
#
#     tools/arm64.sh [ARGUMENT...]        arguments of pytest, which is given tests/core unless there are any
#
# A Debian of arm64 is made once in /var/cache/urdf-ik-arm64 and gets the sources as they are at each call. QEMU emulates its
# programs, which makes them ten times slower, but for the compiler: that is this machine's own, which compiles for arm64.
set -euo pipefail
cd "$(dirname "$0")/.."
((EUID == 0)) || exec sudo bash tools/arm64.sh "$@"
root=/var/cache/urdf-ik-arm64
register=/proc/sys/fs/binfmt_misc

# What is mounted is seen by this script alone, and gone when it ends: nothing that is deleted later reaches through it.
if [[ -z ${URDF_IK_OWN_MOUNTS-} ]]; then
    URDF_IK_OWN_MOUNTS=1 exec unshare --mount bash tools/arm64.sh "$@"
fi

# A program in the other Debian. What this machine's Python, make and pip were told is not for those there.
inside() {
    env -u MAKEFLAGS -u MAKELEVEL -u PYTHONPATH -u VIRTUAL_ENV -u PIP_FIND_LINKS -u URDF_IK_ISA DEBIAN_FRONTEND=noninteractive \
        CXX=aarch64-linux-gnu-g++ CMAKE_ARGS="-DURDF_IK_WERROR=ON -DURDF_IK_TESTS=ON" chroot "$root" "$@"
}

if ! type qemu-aarch64-static debootstrap aarch64-linux-gnu-g++ >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends qemu-user-static debootstrap g++-aarch64-linux-gnu
fi
# Programs of arm64 are to run by their names. Debian sees to that where systemd runs; a container has to ask.
[[ -e $register/register ]] || mount -t binfmt_misc none "$register"
[[ -e $register/qemu-aarch64 ]] || cat /usr/lib/binfmt.d/qemu-aarch64.conf >"$register/register"

if [[ ! -e $root/made ]]; then
    rm -rf "$root"
    suite=$(. /etc/os-release && echo "$VERSION_CODENAME")  # this machine's: a newer compiler has a newer library
    debootstrap --arch=arm64 --variant=minbase --include=ca-certificates,libgomp1,make,python3-dev,python3-venv "$suite" "$root"
    touch "$root/made"
fi
mount -t proc proc "$root/proc"
# The devices, and where this machine has the compiler and the libraries of x86-64 that it needs.
for folder in /dev /lib64 /usr/lib/x86_64-linux-gnu /usr/lib/gcc-cross /usr/aarch64-linux-gnu; do
    mkdir -p "$root$folder"
    mount --bind "$folder" "$root$folder"
done
cp -a /usr/bin/aarch64-linux-gnu-* "$root/usr/bin"
ln -sf aarch64-linux-gnu-nm "$root/usr/bin/nm"  # a test reads symbols
cp /etc/resolv.conf "$root/etc/resolv.conf"
cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/ca-certificates.crt"

# The build stays, so that the next call compiles what has changed.
sources=(CHANGELOG.md CMakeLists.txt LICENSE Makefile README.md docs pyproject.toml src tests tools urdf)
mkdir -p "$root/urdf-ik"
(cd "$root/urdf-ik" && rm -rf "${sources[@]}")
cp -a "${sources[@]}" "$root/urdf-ik"
inside make -C /urdf-ik run VENV=/venv ARGS=  # pytest's are in the environment
inside /venv/bin/pip install -q --disable-pip-version-check example-robot-data hypothesis nbmake pytest robot_descriptions xacro
inside /venv/bin/urdf-ik doctor
(($#)) || set -- tests/core
inside sh -c 'cd /urdf-ik && exec /venv/bin/python -m pytest -q "$@"' sh "$@"
