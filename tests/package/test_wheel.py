"""The wheel as others get it: built, installed into an environment of its own, used elsewhere, without a compiler."""

import json
import os
import re
import shutil
import site
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from dataclasses import dataclass
from pathlib import Path

import consumer
import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, chromium

from urdf_ik.export.page import WEB
from urdf_ik.model import catalogue

ROOT = Path(__file__).resolve().parents[2]
OWN = tuple(catalogue.BUNDLED)
pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Installed:
    """An environment that holds the wheel, and a folder that has nothing to do with the repository."""

    wheel: Path
    sdist: Path
    environment: Path
    elsewhere: Path

    def run(self, command: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run one of the environment's commands in the other folder; no other program is on its path."""
        folder = self.environment / "bin"
        program = folder / command
        return run(str(program), *arguments, cwd=self.elsewhere, PATH=str(folder))


def run(*command: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a command that sees neither this environment's PYTHONPATH nor its virtual environment."""
    hidden = {"PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"}
    env = {key: value for key, value in os.environ.items() if key not in hidden} | variables
    return subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=900, check=False)


def succeed(*command: str, cwd: Path) -> None:
    """Run a command that must not fail."""
    done = run(*command, cwd=cwd)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"


def built(kind: str, source: Path, place: Path, *settings: str) -> Path:
    """The sdist or wheel of a folder, built by what this environment holds, with the compiler that built it."""
    options = [option for setting in settings for option in ("--config-setting", setting)]
    succeed(
        sys.executable, str(ROOT / "tools" / "with_compiler.py"), "--each", sys.executable, "-m", "build", f"--{kind}",
        "--no-isolation", *options, "--outdir", str(place / kind), str(source), cwd=place,
    )  # fmt: skip
    (file,) = (place / kind).iterdir()
    return file


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The sdist, the wheel, and an environment with that wheel.

    The wheel takes what is compiled from the folder of the editable install, so that nothing is compiled twice.
    Dependencies come from the environment that runs the tests, so nothing is fetched. They are found after the
    environment's own packages: of urdf_ik, the wheel's copy comes first.
    """
    place = tmp_path_factory.mktemp("wheel")
    sdist = built("sdist", ROOT, place)
    wheel = built("wheel", ROOT, place, "build-dir=build/{wheel_tag}")
    environment = with_dependencies(place / "environment")
    pip = (sys.executable, "-m", "pip", "--python", str(environment), "--disable-pip-version-check")
    succeed(*pip, "install", "--no-index", "--no-deps", str(wheel), cwd=place)
    elsewhere = place / "elsewhere"
    elsewhere.mkdir()
    return Installed(wheel, sdist, environment, elsewhere)


def with_dependencies(environment: Path, *, with_pip: bool = False) -> Path:
    """A new environment that finds the packages of this one, but not this project."""
    venv.create(environment, with_pip=with_pip)
    own = sysconfig.get_path("purelib", "venv", vars={"base": str(environment), "platbase": str(environment)})
    # addsitedir, since some dependencies (Pinocchio) are found by .pth files of their own; not that of this project's
    # editable install, whose finder would come first.
    lines = [f"import site; site.addsitedir({folder!r})" for folder in site.getsitepackages()]
    lines.append("import sys; sys.meta_path[:] = [f for f in sys.meta_path if not hasattr(f, 'known_wheel_files')]")
    (Path(own) / "zz_dependencies.pth").write_text("\n".join(lines) + "\n")
    return environment


def test_sdist_holds_all_that_a_build_reads(installed: Installed, tmp_path: Path) -> None:
    """CMake configures the unpacked sdist, which fails where a source is missing, and no file of src is left out."""
    with tarfile.open(installed.sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (source,) = tmp_path.iterdir()
    succeed(
        sys.executable, str(ROOT / "tools" / "with_compiler.py"), "cmake", "-S", str(source),
        "-B", str(tmp_path / "build"), "-G", "Ninja", f"-DPython_EXECUTABLE={sys.executable}", cwd=tmp_path,
    )  # fmt: skip
    assert not [path for path in source.rglob("*") if path.name in (".venv", "__pycache__") or path.suffix == ".so"]
    built_from = (".py", ".pyi", ".typed", ".in", ".cpp", ".hpp", ".urdf")
    for folder in ("src", "urdf", "tests", "notebooks"):
        files = [path.relative_to(ROOT) for path in (ROOT / folder).rglob("*") if path.suffix in built_from]
        assert not [file for file in files if not (source / file).is_file()]


def test_wheel_holds_the_package_and_the_bundled_urdfs(installed: Installed) -> None:
    """All modules, py.typed and the repository's URDFs, unchanged; nothing outside the package."""
    with zipfile.ZipFile(installed.wheel) as archive:
        names = set(archive.namelist())
        for name in OWN:
            assert archive.read(f"urdf_ik/bundled/urdf/{name}.urdf") == (ROOT / "urdf" / f"{name}.urdf").read_bytes()
    modules = {path.relative_to(ROOT / "src").as_posix() for path in (ROOT / "src" / "urdf_ik").rglob("*.py")}
    assert modules | {"urdf_ik/py.typed", "urdf_ik/_core.pyi"} <= names
    (core,) = (name for name in names if name.endswith(".so"))
    assert core.startswith("urdf_ik/_core.")
    assert not installed.wheel.name.endswith("-any.whl")
    assert {name.split("/")[0].split("-")[0] for name in names} == {"urdf_ik", "urdf_ik_pytest.py"}


def test_the_installed_package_needs_neither_the_repository_nor_a_compiler(installed: Installed) -> None:
    """With nothing but the environment's own programs on the path: package, URDFs and core are those of the wheel."""
    code = "import json, shutil, urdf_ik, urdf_ik._core as core; from urdf_ik.model import catalogue; "
    code += "arm = urdf_ik.load('zyyzyz_6r'); n = len(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))); "
    code += f"files = [urdf_ik.__file__, core.__file__, *(str(catalogue.resolve(name).path) for name in {OWN})]; "
    code += "print(json.dumps([n, files, list(filter(shutil.which, ('cc', 'c++', 'gcc', 'clang', 'ld', 'cmake')))]))"
    done = installed.run("python", "-c", code)
    assert done.returncode == 0, done.stderr
    solutions, files, compilers = json.loads(done.stdout)
    assert (solutions, compilers) == (8, [])
    assert all(Path(file).is_relative_to(installed.environment.resolve()) for file in files), files


@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_a_cpp_project_builds_against_the_wheel(installed: Installed, tmp_path: Path) -> None:
    """find_package takes the wheel's sources; an arm is exported by the wheel's Python; programs in C++ and C solve."""
    said = installed.run("python", "-m", "urdf_ik.cmake")
    folder = Path(said.stdout.strip())
    assert folder.is_relative_to(installed.environment.resolve()), said
    consumer.build(tmp_path / "build", f"-Durdf_ik_DIR={folder}")
    consumer.solves(tmp_path / "build", tmp_path / "arm.json")


def test_the_wheel_can_be_published(installed: Installed) -> None:
    """PyPI can show its description, and it has at most 10 MB, with WebAssembly and the page."""
    succeed(sys.executable, "-m", "twine", "check", "--strict", str(installed.wheel), str(installed.sdist), cwd=ROOT)
    assert installed.wheel.stat().st_size <= 10_000_000


@pytest.mark.skipif(
    CHROMIUM is None or not all((WEB / name).is_file() for name in ("urdf_ik.wasm", "page.bundle.js")),
    reason=f"{INSTALL}; make wasm page",
)
def test_the_wheel_writes_a_page_of_all_solutions(installed: Installed) -> None:
    """`export --html` of the wheel, opened from disk: the solutions that Python lists, eight."""
    done = installed.run("urdf-ik", "export", "zyyzyz_6r", "--html", "arm.html")
    assert done.returncode == 0, done.stderr
    with chromium() as browser:
        page = browser.new_page(offline=True)
        page.goto((installed.elsewhere / "arm.html").as_uri())
        page.wait_for_function("document.documentElement.dataset.ready", timeout=1000.0 * PATIENCE)
        assert page.locator("#solutions li").count() == 8


def test_the_steps_of_the_page_about_ci_run_where_the_wheel_is_all_there_is(
    installed: Installed, tmp_path: Path
) -> None:
    """In an empty environment, each line of the workflow in turn: status 0; an axis negated, the lock says no.

    pip finds the dependencies and pytest where this environment has them, so nothing is fetched.
    """
    page = ROOT.joinpath("docs/how-to/ci.md").read_text()
    install, *steps = re.findall(r"- run: (.*)", page)
    assert len(steps) == 4 and install.startswith("pip install")
    programs = with_dependencies(tmp_path / "environment", with_pip=True) / "bin"
    pytest_of_this = programs / "pytest"
    pytest_of_this.write_text(f"#!{programs / 'python'}\nimport sys, pytest\nsys.exit(pytest.console_main())\n")
    pytest_of_this.chmod(0o755)
    folder = tmp_path / "project"
    (folder / "dist").mkdir(parents=True)
    (folder / "dist" / installed.wheel.name).symlink_to(installed.wheel)
    arm = catalogue.resolve("zyyzyz_6r").path.read_text()
    (folder / "my_arm.urdf").write_text(arm)

    def step(line: str) -> subprocess.CompletedProcess[str]:
        quick = line.replace("-n 500", "-n 5") + (" --urdf-poses 5" if line.startswith("pytest") else "")
        path = f"{programs}:/usr/bin:/bin"
        return run("/bin/sh", "-c", quick, cwd=folder, PATH=path, PIP_NO_INDEX="1", PIP_DISABLE_PIP_VERSION_CHECK="1")

    (freeze,) = re.findall(r"^pytest .*--urdf-freeze", page, re.MULTILINE)
    for line in (install, freeze, *steps):
        done = step(line)
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
    where = step("python -c 'import urdf_ik, urdf_ik_pytest; print(urdf_ik.__file__, urdf_ik_pytest.__file__)'")
    assert all(Path(file).is_relative_to(programs.parent.resolve()) for file in where.stdout.split()), where
    axis = '<axis xyz="0 1 0"/>'
    (folder / "my_arm.urdf").write_text(arm.replace(axis, axis.replace("1", "-1"), 1))
    status = {line: step(line) for line in steps if "doctor" not in line}
    assert [done.returncode for done in status.values()] == [1, 0, 1]
    assert all("joint_2" in done.stdout for done in status.values() if done.returncode)
