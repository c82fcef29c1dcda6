"""``urdf_ik.torch.ik`` against torch's own numerical derivatives and against the package's."""

import subprocess
import sys

import numpy as np
import pytest
from arms_hollow import hollow

import urdf_ik
from urdf_ik.errors import ArgumentError
from urdf_ik.interop.differentiable import Differentiable

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'urdf-ik[torch]'")
func = pytest.importorskip("torch.func")

# What torch itself imports for its forward mode calls a function of its own that it has deprecated.
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:.*torch.jit.script:DeprecationWarning")]

SIX, SEVEN = (urdf_ik.load(name) for name in ("zyyzyz_6r", "panda"))
Q6 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
Q7 = np.array([0.1, 0.3, 0.2, -1.5, 0.3, 1.8, 0.4])


def poses(m: int) -> torch.Tensor:
    """Poses (m, 4, 4) near a regular one."""
    return torch.tensor(SIX.fk(Q6 + np.random.default_rng(0).uniform(-0.1, 0.1, (m, 6))))


def test_the_branches_are_those_of_ik() -> None:
    """Same values, same order, NaN where there is no solution; importing the package does not import torch."""
    T = poses(5)
    T[2, 0, 3] += 9.0
    found = urdf_ik.torch.ik(SIX, T)
    s = SIX.ik(T.numpy())
    np.testing.assert_allclose(found.q.numpy(), s.q, atol=1e-12)
    np.testing.assert_array_equal(found.valid.numpy(), s.valid)
    code = "import sys, urdf_ik; urdf_ik.load('planar_2r'); assert not {'torch', 'jax'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


def test_gradcheck_of_poses_in_both_modes_and_twice() -> None:
    """Entries of the pose change one by one; second derivatives too."""
    T = poses(1)[0].requires_grad_(True)
    assert torch.autograd.gradcheck(
        lambda T: urdf_ik.torch.ik(SIX, T).q, (T,), eps=1e-7, atol=1e-4, check_forward_ad=True
    )
    assert torch.autograd.gradgradcheck(lambda T: urdf_ik.torch.ik(SIX, T).q[:2], (T,), eps=1e-7, atol=1e-3, rtol=1e-3)


def test_other_numbers_of_the_urdf_give_the_other_arm() -> None:
    """A longer link: the solutions are those of a URDF with that link, by its own forward kinematics."""
    g = urdf_ik.torch.geometry(SIX)
    longer = urdf_ik.load(SIX.model.xml.decode().replace('origin xyz="0 0 1"', 'origin xyz="0 0 1.1"'))
    changed = torch.tensor(urdf_ik.torch.geometry(longer).numpy())
    assert (changed != g).any()
    T = torch.tensor(longer.fk(Q6))
    found = urdf_ik.torch.ik(SIX, T, geometry=changed)
    np.testing.assert_allclose(found.q.numpy(), longer.ik(T.numpy()).q, atol=1e-9)


def test_function_transforms() -> None:
    """With vmap over poses, jvp and jacrev agree with dq_dT."""
    T = poses(3)
    s = SIX.ik(T.numpy())
    twice = func.vmap(func.vmap(lambda T: urdf_ik.torch.ik(SIX, T).q))(T[None])[0]
    np.testing.assert_allclose(twice.numpy(), s.q, atol=1e-12)
    np.testing.assert_allclose(func.vmap(lambda T: urdf_ik.torch.ik(SIX, T).q)(T).numpy(), s.q, atol=1e-12)
    J = func.vmap(func.jacrev(lambda T: urdf_ik.torch.ik(SIX, T).q))(T)[..., :3, 3]
    np.testing.assert_allclose(J.numpy(), s.dq_dT()[..., :3], atol=1e-9)
    step = torch.zeros(3, 4, 4, dtype=torch.float64)
    step[:, 1, 3] = 1.0
    _, change = func.jvp(lambda T: urdf_ik.torch.ik(SIX, T).q, (T,), (step,))
    np.testing.assert_allclose(change.numpy(), s.dq_dT()[..., 1], atol=1e-9)


def test_vmap_is_one_call_for_all_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Poses or values of the redundancy parameter; several geometries are one call each."""
    arm, calls = SEVEN, []
    answers = Differentiable.answers
    monkeypatch.setattr(Differentiable, "answers", lambda *args: calls.append(1) or answers(*args))
    T, values = torch.tensor(arm.fk(Q7)), torch.tensor([0.1, 0.2, 0.3], dtype=torch.float64)

    def ik(T: torch.Tensor, at: torch.Tensor, geometry: torch.Tensor | None = None) -> torch.Tensor:
        return urdf_ik.torch.ik(arm, T, redundancy=at, geometry=geometry, at_folds="nan").q

    expected = arm.ik(T.numpy(), redundancy=values.numpy()).q
    np.testing.assert_allclose(func.vmap(ik, (None, 0))(T, values).numpy(), expected, atol=1e-12)
    np.testing.assert_allclose(func.vmap(ik)(T.expand(3, 4, 4), values).numpy(), expected, atol=1e-12)
    assert len(calls) == 2
    several = urdf_ik.torch.geometry(arm).expand(2, -1)
    np.testing.assert_allclose(func.vmap(ik, (None, None, 0))(T, values, several)[1].numpy(), expected, atol=1e-12)
    assert len(calls) == 4


def test_missing_branches_do_not_spoil_the_gradient() -> None:
    """A loss over the valid solutions has finite gradients where some poses have none."""
    T = poses(2)
    T[1, 0, 3] += 9.0
    T.requires_grad_(True)
    found = urdf_ik.torch.ik(SIX, T)
    found.q[found.valid].sum().backward()
    assert torch.isfinite(T.grad).all() and (T.grad[0] != 0.0).any() and (T.grad[1] == 0.0).all()


def test_folds_are_refused_or_clipped() -> None:
    """A stretched wrist: refused by its branch's name, NaN, or a bounded derivative."""
    T = torch.tensor(SIX.fk([0.3, -0.5, 0.8, 0.4, 0.0, -0.2]), requires_grad=True)
    with pytest.raises(ArgumentError, match="is singular and has no derivative"):
        urdf_ik.torch.ik(SIX, T)
    with pytest.raises(ArgumentError, match="'raise', 'nan', 'clip'"):
        urdf_ik.torch.ik(SIX, T, at_folds="ignore")
    sums = {}
    for how in ("nan", "clip"):
        found = urdf_ik.torch.ik(SIX, T, at_folds=how)
        (sums[how],) = torch.autograd.grad(found.q[found.valid].sum(), T)
    assert torch.isnan(sums["nan"]).any()
    assert torch.isfinite(sums["clip"]).all()


def redundant() -> dict[str, urdf_ik.Arm]:
    """An arm with a joint as parameter, one with a free axis, and one with both."""
    return {
        "joint": urdf_ik.load("srs_7r").with_redundancy("joint_1"),
        "free axis": SIX.with_free_axis("z", at=[0.03, 0.0, 0.1]),
        "free axis and joint": SEVEN.with_free_axis("z"),
    }


@pytest.mark.parametrize("name", ["joint", "free axis", "free axis and joint"])
def test_every_redundancy_parameter_is_an_input(name: str) -> None:
    """Derivatives by the pose and by the parameters are those of dq_dT and dq_dredundancy."""
    arm = redundant()[name]
    T = torch.tensor(arm.fk(Q6 if arm.dof == 6 else Q7))
    values = torch.full((len(arm.solver.parameters),), 0.4, dtype=torch.float64)
    at = values[0] if len(values) == 1 else values
    s = arm.ik(T.numpy(), redundancy=at.numpy())
    regular = s.valid & (np.linalg.norm(s.dq_dredundancy(), axis=(-2, -1)) < 50.0)
    assert regular.any()
    by_pose, by_value = torch.autograd.functional.jacobian(
        lambda T, at: urdf_ik.torch.ik(arm, T, redundancy=at, at_folds="nan").q, (T, at)
    )
    np.testing.assert_allclose(by_pose.numpy()[regular][..., :3, 3], s.dq_dT()[regular][..., :3], atol=1e-8)
    slope = by_value.numpy().reshape(*s.q.shape, -1)
    np.testing.assert_allclose(slope[regular], s.dq_dredundancy()[regular], atol=1e-8)


def mimicking() -> urdf_ik.Arm:
    """Four joints that drive five axes."""
    xml = SIX.model.xml.decode()
    end = xml.index("</joint>", xml.index('<joint name="joint_5"'))
    return urdf_ik.load(xml[:end] + '<mimic joint="joint_3" multiplier="0.5"/>' + xml[end:], locked={"joint_1": 0.0})


def test_joints_that_mimic_others_have_derivatives() -> None:
    """Those of dq_dT, and by the URDF's numbers, multipliers' offsets among them, those of dq_dgeometry."""
    arm = mimicking()
    T = torch.tensor(arm.fk(Q6[[1, 2, 3, 5]]))
    s = arm.ik(T.numpy())
    steady = s.valid & (np.linalg.norm(s.dq_dT(), axis=(-2, -1)) < 50.0)
    assert steady.any()
    J = torch.autograd.functional.jacobian(lambda T: urdf_ik.torch.ik(arm, T, at_folds="nan").q[steady], T)
    np.testing.assert_allclose(J.numpy()[..., :3, 3], s.dq_dT()[steady][..., :3], atol=1e-8)
    G = torch.autograd.functional.jacobian(
        lambda g: urdf_ik.torch.ik(arm, T, geometry=g, at_folds="nan").q[steady], urdf_ik.torch.geometry(arm)
    )
    np.testing.assert_allclose(G.numpy(), s.dq_dgeometry()[steady], atol=1e-8)


def test_gradcheck_of_the_urdfs_numbers() -> None:
    """By torch's own differences, which solve URDFs with other numbers, of a wrist that mimics."""
    arm = urdf_ik.load(hollow("mirrored"), "base", "tool")
    T = torch.tensor(arm.fk(Q6))

    def nearest(g: torch.Tensor) -> torch.Tensor:
        found = urdf_ik.torch.ik(arm, T, geometry=g, at_folds="nan").q
        return found[(found.detach() - torch.tensor(Q6)).abs().amax(-1).nan_to_num(9.0).argmin()]

    g = urdf_ik.torch.geometry(arm).requires_grad_(True)
    assert torch.autograd.gradcheck(nearest, (g,), eps=1e-6, atol=1e-4, rtol=1e-4)
