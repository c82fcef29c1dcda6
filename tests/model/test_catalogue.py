"""Names of arms: every one leads to a URDF that holds its chain, and a name that does not says what would."""

import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from lxml import etree

import urdf_ik
from urdf_ik.errors import ArgumentError, ChainError
from urdf_ik.model import catalogue, downloads


def movable_joints(path: Path, base: str, tip: str) -> list[str]:
    """Names of the joints that move tip against base, going up from the tip."""
    joints = {joint.find("child").get("link"): joint for joint in etree.parse(path).getroot().findall("joint")}
    names = []
    link = tip
    while link != base:
        joint = joints[link]
        if joint.get("type") != "fixed":
            names.append(joint.get("name"))
        link = joint.find("parent").get("link")
    return names


@pytest.mark.parametrize("name", catalogue.names())
def test_every_name_leads_to_a_chain(name: str) -> None:
    """The file exists, and between its base and its tip are two to seven movable joints."""
    entry = catalogue.resolve(name)
    assert entry.path.is_absolute() and entry.path.suffix == ".urdf"
    assert entry.base is not None and entry.tip is not None
    assert 2 <= len(movable_joints(entry.path, entry.base, entry.tip)) <= 7


@pytest.mark.parametrize("name", catalogue.EXAMPLE_ROBOT_DATA)
def test_meshes_lie_in_the_package_folders(name: str) -> None:
    """Every mesh that the URDF names is a file below one of the entry's package folders."""
    entry = catalogue.resolve(name)
    addresses = {mesh.get("filename") for mesh in etree.parse(entry.path).iter("mesh")}
    inside = [address.removeprefix("package://") for address in addresses]
    assert all(any((folder / path).is_file() for folder in entry.package_dirs) for path in inside)
    # The arms are drawn with meshes, but for a pendulum of two links.
    assert addresses or name == "twodof"


def test_bundled_arms_are_all_named() -> None:
    """Every URDF of the bundled folder has a name, and bundled names come first."""
    folder = catalogue.resolve("zyyzyz_6r").path.parent
    files = {path.stem for path in folder.glob("*.urdf")}
    assert files == set(catalogue.BUNDLED) == set(catalogue.names()[: len(files)])


@pytest.mark.parametrize(
    ("name", "nearest"),
    [("zyyzyz", "zyyzyz_6r"), ("UR5", "ur5"), ("ur5_arm", "ur5"), ("pand", "panda"), ("baxter_lef", "baxter_left")],
)
def test_unknown_name_lists_the_nearest(name: str, nearest: str) -> None:
    """A name with a slip in it is refused, and the message holds the name that was meant."""
    with pytest.raises(ArgumentError, match=rf"'{name}'; nearest: .*\b{nearest}\b"):
        catalogue.resolve(name)


@pytest.mark.parametrize("installed", ["not at all", "without a list of files", "with other files"])
def test_missing_package_says_how_to_install_it(installed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without example-robot-data its names say how to install it, and bundled names still work."""

    def files(distribution: str) -> list[metadata.PackagePath] | None:
        if installed == "not at all":
            raise metadata.PackageNotFoundError(distribution)
        return None if installed == "without a list of files" else [metadata.PackagePath("share/else/package.xml")]

    monkeypatch.setattr(metadata, "files", files)
    catalogue._found_share.cache_clear()  # as in a process that has not asked yet
    with pytest.raises(ArgumentError, match=r"'ur5' .* example-robot-data.*pip install 'example-robot-data>="):
        catalogue.resolve("ur5")
    assert catalogue.resolve("dh_6r").path.is_file()


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The models of robot_descriptions, each downloaded from a repository on this machine; gives its cache."""
    repositories = pytest.importorskip("robot_descriptions._repositories").REPOSITORIES
    share = catalogue._example_robot_data_share()
    assert share is not None
    upstream = tmp_path / "upstream"
    folder = upstream / "robots" / "panda_description"
    shutil.copytree(share / "example-robot-data/robots/panda_description/urdf", folder / "urdf")
    git = ["git", "-C", str(upstream), "-c", "user.name=n", "-c", "user.email=e@example.org", "-c", "commit.gpgsign=no"]
    for arguments in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "models"]):
        subprocess.run([*git, *arguments], check=True)
    head = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()
    monkeypatch.setattr(repositories["example-robot-data"], "url", str(upstream))
    monkeypatch.setattr(repositories["example-robot-data"], "commit", head)
    monkeypatch.setattr(repositories["Universal_Robots_ROS2_Description"], "url", str(tmp_path / "nothing"))
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    for name in ("panda_description", "ur10e_description"):
        monkeypatch.delitem(sys.modules, f"robot_descriptions.{name}", raising=False)
    return tmp_path / "cache"


def test_a_described_robot_is_downloaded_once(described: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model of robot_descriptions is not here, is downloaded when it is asked for, and is the same arm as by file."""
    with monkeypatch.context() as patch:
        patch.setattr(catalogue, "_example_robot_data_share", lambda: None)
        assert not catalogue.is_here("panda_description")
        arm = urdf_ik.load("panda_description")
        assert catalogue.is_here("panda_description") and described in Path(arm.model.source).parents
    same = urdf_ik.load("panda")
    assert (arm.base, arm.tip, arm.joint_names) == (same.base, same.tip, same.joint_names)
    assert (arm.fk([0.1] * arm.dof) == same.fk([0.1] * arm.dof)).all()


def test_what_cannot_be_downloaded_says_so(described: Path) -> None:
    """Without the repository the message says what was tried; the short name leads to the same model."""
    for name in ("ur10e", "ur10e_description"):
        with pytest.raises(ArgumentError, match=r"'ur10e_description' is not .*could not download it.* here: ur10"):
            urdf_ik.load(name)
    assert not catalogue.is_here("ur10e")


@pytest.mark.parametrize("name", ["panda", "tiago", "ur10"])
def test_what_example_robot_data_has_is_not_downloaded(name: str, described: Path) -> None:
    """The name that robot_descriptions has, or had, for an installed arm is that arm, in an empty cache."""
    assert catalogue.is_here(f"{name}_description")
    assert catalogue.resolve(f"{name}_description") == catalogue.resolve(name)
    assert not described.exists()


def test_without_robot_descriptions_the_nearest_name_is_still_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the package is not installed an unknown name brings its installation along."""
    monkeypatch.setattr(downloads, "_descriptions", dict)
    with pytest.raises(ArgumentError, match=r"no arm is called 'ur10e'; nearest: .*ur10.*pip install"):
        catalogue.resolve("ur10e")


@pytest.mark.parametrize("name", catalogue.EXAMPLE_ROBOT_DATA)
def test_the_chain_that_is_meant_is_never_another(name: str) -> None:
    """Without base and tip: the catalogue's joints, those before them included, or a doubt that lists them."""
    entry = catalogue.resolve(name)
    model = urdf_ik.model.urdf.read(entry.path)
    wanted = {joint.name for joint in model.path_between(entry.base, entry.tip) if joint.type != "fixed"}
    try:
        base, tip = model.resolve_chain()
    except ChainError:
        assert any(wanted <= {*each.before, *each.joints} for each in model.chains())
        return
    assert (base, tip) == (entry.base, entry.tip)


@pytest.mark.parametrize("name", [name for name in catalogue.names() if catalogue.is_here(name)])
def test_the_chain_does_not_depend_on_how_the_file_was_named(name: str, tmp_path: Path) -> None:
    """By name, by path, as text and as xacro: the same base and tip, or a doubt that the name settles."""
    path = catalogue.resolve(name).path
    arm = urdf_ik.load(name)
    xacro = tmp_path / "arm.xacro"
    xacro.write_bytes(path.read_bytes())
    for source in (path, path.read_text(encoding="utf-8"), xacro):
        try:
            other = urdf_ik.load(source)
        except ChainError as error:
            assert name.endswith(("_left", "_right")) or name in ("dual_6r", "tiago"), error
        else:
            assert (other.base, other.tip, other.joint_names) == (arm.base, arm.tip, arm.joint_names)
