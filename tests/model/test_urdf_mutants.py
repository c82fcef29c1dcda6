"""Mutants of sound URDFs: refused in words, or read, and then their kinematics are Pinocchio's.

The seed and the number of mutants are those of URDF_IK_MUTANTS, 'seed:count'; by default a few hundred, which takes
some twenty seconds.
"""

import os
import re

import numpy as np
import pytest
from chains import joint, robot

import urdf_ik
from urdf_ik import UrdfIkError
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.model import catalogue

SEED, COUNT = map(int, os.environ.get("URDF_IK_MUTANTS", "7:240").split(":"))
FOLLOWS = {2: '<mimic joint="j1" multiplier="-1"/>', 3: '<mimic joint="j2" multiplier="0.5"/>'}
LINKED = robot(
    *(
        joint(f"j{k}", "revolute", f"l{k}", f"l{k + 1}", "0.1 0 0.1", axis=axis, more=FOLLOWS.get(k, ""))
        for k, axis in enumerate(("0 0 1", "0 1 0", "0 1 0", "0 1 0", "1 0 0"))
    )
)
TEXTS = [catalogue.resolve(name).path.read_bytes() for name in ("planar_2r", "puma_560", "scara_rrpr", "srs_7r")]
TEXTS.append(LINKED.encode())
NUMBERS = (
    b"0", b"-0", b"1e-17", b"1e-9", b"1e9", b"1e16", b"1e155", b"1e308", b"1e999", b"nan", b"inf", b"", b"x", b"1_0"
)  # fmt: skip
NUMBER = re.compile(rb"(?<=[\" ])[-+]?\d+\.?\d*(?:e[-+]?\d+)?(?=[\" ])")
PART = re.compile(rb"<(origin|axis|limit|parent|child|joint|link|mimic)\b[^>]*/?>")


def mutant(rng: np.random.Generator) -> bytes:
    """A text that is cut off, or of which bytes, numbers, attributes or elements are changed, doubled or missing."""
    text = TEXTS[int(rng.integers(len(TEXTS)))]
    for _ in range(int(rng.integers(1, 4))):
        kind, place = int(rng.integers(8)), int(rng.integers(max(len(text), 1)))
        length = int(rng.integers(1, 40))
        if kind == 0:
            text = text[:place]
        elif kind == 1:
            text = text[:place] + bytes([int(rng.integers(256))]) + text[place + 1 :]
        elif kind == 2:
            text = text[:place] + text[place + length :]
        elif kind == 3:
            text = text[:place] + text[place : place + length] * 2 + text[place + length :]
        elif kind == 7:
            names = re.findall(rb'<joint name="([^"]+)"', text) or [b"j"]
            one, number = names[int(rng.integers(len(names)))], NUMBERS[int(rng.integers(len(NUMBERS)))]
            ends = [each.start() for each in re.finditer(b"</joint>", text)] or [place]
            at = ends[int(rng.integers(len(ends)))]
            text = text[:at] + b'<mimic joint="' + one + b'" multiplier="' + number + b'"/>' + text[at:]
        else:
            found = list((NUMBER if kind < 6 else PART).finditer(text))
            if found:
                one = found[int(rng.integers(len(found)))]
                if kind == 6:
                    new = b"" if rng.random() < 0.5 else one[0] * 2
                elif kind == 5:
                    new = NUMBERS[int(rng.integers(len(NUMBERS)))]
                else:
                    new = repr(float(one[0]) * float(rng.normal(1.0, 0.3))).encode()
                text = text[: one.start()] + new + text[one.end() :]
    return text


def check(text: bytes, rng: np.random.Generator) -> bool:
    """Whether it was read; then forward kinematics are Pinocchio's, and so is every solution."""
    try:
        arm = urdf_ik.load(text)  # type: ignore[arg-type]
    except UrdfIkError as error:
        assert str(error) and len(str(error)) < 20_000
        return False
    reference = Reference(arm.model, arm.base, arm.tip)
    lower, upper = np.clip(arm.limits.T, -3.0, 3.0)
    q = rng.uniform(np.minimum(lower, upper), np.maximum(lower, upper))
    T = arm.fk(q)
    size = max(reference.size, 1.0)
    assert np.abs(T - reference.pose(q)).max() < 1e-9 * size
    try:
        found = arm.ik(T)
    except UrdfIkError:
        return True
    for solution in found.to_array():
        position, angle = reference.error(solution, T)
        assert position < 1e-9 * size and angle < 1e-9, (position, angle)
    return True


@pytest.mark.parametrize("part", range(8))
def test_mutants_are_refused_or_are_pinocchios(part: int) -> None:
    """Both happen, and nothing else does."""
    rng = np.random.default_rng((SEED, part))
    read = 0
    for k in range(max(COUNT // 8, 1)):
        text = mutant(rng)
        try:
            read += check(text, rng)
        except Exception as error:
            raise AssertionError(f"mutant {k} of part {part}, seed {SEED}: {text[:4000]!r}") from error
    assert 0 < read < max(COUNT // 8, 1)
