"""The npm module under Node: the bits of x86-64-v2, and errors that say what is wrong."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import web_arms
from core_samples import fresh
from test_compiled_arms import DEFECTS, broken

import urdf_ik
from urdf_ik import _core

pytestmark = web_arms.needs_node

# Python's own answers at the level whose arithmetic WebAssembly has, and the files that both solve from.
_EXPECTED = """
import pathlib, sys
import native_arms, numpy as np, urdf_ik
from test_compiled_arms import EVERY
for k, (name, arm) in enumerate(EVERY):
    place = pathlib.Path(sys.argv[1]) / str(k)
    place.with_suffix(".json").write_text(urdf_ik.compile(arm))
    T, values = native_arms.targets(arm)
    s = native_arms.expected(arm, T, values)
    first = np.nan_to_num(s.q[np.arange(len(T)), s.valid.argmax(axis=-1)])
    np.savez(place, T=T, q=s.q, valid=s.valid, singular=s.singular != 0, status=s.status, branches=s.branches,
             pose=arm.fk(first), **({} if values is None else {"values": values}))
    print(name)
"""


@pytest.mark.slow
@pytest.mark.skipif("v2" not in _core.levels(), reason="the core was built without x86-64-v2, whose arithmetic it has")
def test_the_module_solves_every_family_with_the_bits_of_v2(tmp_path: Path) -> None:
    """Of random, round and singular poses: solutions, statuses, branch names, and the poses that they lead to."""
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    names = fresh(_EXPECTED, str(tmp_path), URDF_IK_ISA="v2", PYTHONPATH=path).splitlines()
    assert len(names) > 100
    for k, name in enumerate(names):
        expected = dict(np.load(tmp_path / f"{k}.npz"))
        seen = web_arms.answers(tmp_path / f"{k}.json", expected["T"], expected.get("values"))
        valid = expected["valid"]
        assert seen.branches == expected["branches"].tolist(), name
        assert (seen.valid == valid).all() and (seen.singular == (valid & expected["singular"])).all(), name
        assert seen.status == expected["status"].tolist(), name
        assert seen.q[valid].tobytes() == expected["q"][valid].tobytes(), name
        some = valid.any(axis=-1)
        assert np.abs(seen.pose[some] - expected["pose"][some]).max() < 1e-12, name


@pytest.mark.parametrize("change", DEFECTS)
def test_a_broken_file_is_refused(change: str, tmp_path: Path) -> None:
    """The module says what is wrong, as Python and C++ do."""
    file = tmp_path / "arm.json"
    file.write_text(broken(change))
    wanted = "no compiled arm" if change == "no JSON" else DEFECTS[change]
    assert wanted in web_arms.refusal(file)


def test_the_module_names_the_version_of_the_package() -> None:
    """package.json has the version of the Python package, and names files that are there."""
    package = json.loads((web_arms.WEB / "package.json").read_text())
    assert package["version"] == urdf_ik.__version__
    assert all((web_arms.WEB / name).is_file() for name in package["files"])
