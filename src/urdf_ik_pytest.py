"""Plugin of pytest: ``pytest --urdf FILE`` holds arms against Pinocchio and their lock files, one test a property.

Every pytest run in an environment with urdf-ik loads this module, so it stands outside the package and imports it only
where ``--urdf`` was given.

A lock file is ``FILE`` with the ending ``.lock.json``, beside it, or what ``--urdf-lock`` names; without it the run
fails, unless ``--urdf-no-lock`` says so. Tests of your own get the arms and the locks by the fixtures ``arm`` and
``arm_lock``.
"""

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.verify.baselines import Lock, Verification
    from urdf_ik.verify.crosscheck import CrossCheck

MARK = "urdf"
READABLE = "can be read"
UNCHANGED = ("kinematics", "limits", "names", "collisions", "visuals", "solutions")
_OF_FILES = ("--urdf", "--urdf-lock")


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options."""
    group = parser.getgroup("urdf-ik", "urdf-ik: arms against Pinocchio")
    repeated: dict[str, Any] = {"action": "append", "default": []}
    group.addoption("--urdf", metavar="FILE", help="cross-check this URDF or catalogue name; repeatable", **repeated)
    group.addoption("--base", metavar="LINK", help="base link: one for all, or one for each --urdf", **repeated)
    group.addoption("--tip", metavar="LINK", help="tip link: one for all, or one for each --urdf", **repeated)
    group.addoption("--urdf-lock", metavar="FILE", help="its lock file: one for each --urdf", **repeated)
    group.addoption("--urdf-freeze", action="store_true", help="write the lock files that are missing")
    group.addoption("--urdf-no-lock", action="store_true", help="an arm without a lock file passes")
    group.addoption("--urdf-poses", metavar="N", type=int, default=200, help="random poses for each --urdf")
    group.addoption("--urdf-seed", metavar="SEED", type=int, default=0, help="seed of the random poses")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> int | pytest.ExitCode | None:
    """Run again with ``--urdf=FILE`` where ``--urdf FILE`` was typed.

    pytest looks for its root and its configuration before any plugin is loaded, beside every argument that is a file.
    """
    args = list(config.invocation_params.args)
    joined: list[str] = []
    for arg in map(str, args):
        # The value of an option as pytest reads it; an argument with a hyphen is another option.
        if joined and joined[-1] in _OF_FILES and not arg.startswith("-"):
            joined[-1] += f"={arg}"
        else:
            joined.append(arg)
    return pytest.main(joined, config.invocation_params.plugins) if len(joined) < len(args) else None


def pytest_configure(config: pytest.Config) -> None:
    """Make the mark known, by which the tests can be chosen: ``-m urdf``."""
    config.addinivalue_line("markers", f"{MARK}: a check that --urdf asked for")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run each test that takes ``arm`` or ``arm_lock`` once for every ``--urdf``."""
    if "_urdf_ik_given" not in metafunc.fixturenames:
        return
    given = _given(metafunc.config)
    nothing = pytest.param(None, id="no arm", marks=pytest.mark.skip(reason="no arm: give --urdf FILE"))
    params = [pytest.param(each, id=each.name) for each in given] or [nothing]
    metafunc.parametrize("_urdf_ik_given", params, indirect=True, scope="session")


@pytest.fixture(scope="session")
def _urdf_ik_given(request: pytest.FixtureRequest) -> "_Given":
    given: _Given = request.param
    return given


@pytest.fixture(scope="session")
def arm(_urdf_ik_given: "_Given") -> "Arm":
    """The arm of ``--urdf``, each of them in turn."""
    return _urdf_ik_given.arm


@pytest.fixture(scope="session")
def arm_lock(_urdf_ik_given: "_Given") -> "Lock":
    """The lock of the arm of ``--urdf``; with ``--urdf-no-lock`` a test is skipped where there is none."""
    lock = _urdf_ik_given.lock
    if lock is None:
        pytest.skip(f"no lock file {_urdf_ik_given.lock_path}, and --urdf-no-lock")
    return lock


@pytest.hookimpl(tryfirst=True)  # before -k and -m choose
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the tests of every ``--urdf`` to what was collected."""
    for given in _given(config):
        checked = _CheckedArm.from_parent(session, name=given.name, nodeid=given.name, given=given)
        items.extend(checked.collect())


class _Given:
    """One ``--urdf`` with its links and its lock.

    Attributes:
        name: what its tests are called.
        source: as typed.
        lock_path: the lock file, which need not be there.
    """

    def __init__(self, config: pytest.Config, name: str, source: str, links: tuple[str | None, str | None],
                 lock: str | None) -> None:  # fmt: skip
        from urdf_ik.verify.baselines import lock_beside

        self.name, self.source = name, source
        self._links, self._freeze = links, config.getoption("--urdf-freeze")
        # pytest may run from elsewhere than where the command was typed.
        path = config.invocation_params.dir / source
        self._source: Path | str = path if path.is_file() else source
        self.lock_path = config.invocation_params.dir / lock if lock else lock_beside(path)
        self._may_lack = config.getoption("--urdf-no-lock")

    @cached_property
    def arm(self) -> "Arm":
        """The arm: base, tip and held joints as given, else those of the lock."""
        import urdf_ik

        base, tip = self._links
        locked: dict[str, float] = {}
        if self.lock_path.is_file():
            frozen = self._read().arm
            locked = dict(frozen.locked)
            base, tip = (frozen.base if base is None else base), (frozen.tip if tip is None else tip)
        return urdf_ik.load(self._source, base=base, tip=tip, locked=locked)

    @property
    def definition(self) -> str:
        """The line that defines the arm of the lines that replay a failure."""
        return f"replay: import urdf_ik; arm = urdf_ik.load({self.source!r}, {self.arm.base!r}, {self.arm.tip!r})"

    @cached_property
    def lock(self) -> "Lock | None":
        """The lock, written first where it is missing and ``--urdf-freeze`` was given; None with ``--urdf-no-lock``."""
        import urdf_ik

        if not self.lock_path.is_file() and self._freeze:
            urdf_ik.freeze(self.arm).save(self.lock_path)
        if self.lock_path.is_file():
            return self._read()
        if self._may_lack:
            return None
        raise urdf_ik.ArgumentError(
            f"there is no lock file {self.lock_path}, so nothing says whether {self.source} has changed; "
            "--urdf-freeze writes it, --urdf-lock names another, --urdf-no-lock goes without"
        )

    @cached_property
    def verification(self) -> "Verification | None":
        """What of the lock holds; None without a lock."""
        return None if self.lock is None else self.lock.verify(self.arm)

    def _read(self) -> "Lock":
        from urdf_ik.verify.baselines import Lock

        return Lock.load(self.lock_path)


class _CheckedArm(pytest.Collector):
    """One ``--urdf``: loaded and checked when the first of its tests runs."""

    def __init__(self, *, given: _Given, **node: Any) -> None:
        super().__init__(**node)
        self.given = given
        self._reported_by = ""
        self.add_marker(MARK)

    def collect(self) -> "Iterator[_Test]":
        """One test a property of the cross-check and of the lock, and one for reading the file."""
        from urdf_ik.verify.crosscheck import PROPERTIES

        for name in (READABLE, *PROPERTIES):
            yield _Test.from_parent(self, name=name, check=partial(self._require_property, name))
        for kind in UNCHANGED:
            name = f"unchanged {kind}"
            yield _Test.from_parent(self, name=name, check=partial(self._require_unchanged, name, kind))

    @cached_property
    def _report(self) -> "CrossCheck | Exception":
        """The cross-check's report, or why there is none."""
        import urdf_ik
        from urdf_ik.verify import crosscheck

        try:
            n, seed = (self.config.getoption(option) for option in ("--urdf-poses", "--urdf-seed"))
            return crosscheck.check(self.given.arm, n=n, seed=seed)
        except urdf_ik.UrdfIkError as error:
            return error

    def _refuse(self, reason: str, name: str) -> None:
        """Fail the first of the tests that runs with why there is no report, and skip the others: it is one fault."""
        if self._reported_by in ("", name):
            self._reported_by = name
            raise _Disagrees(reason)
        words = f"{self.given.source} or its lock cannot be read; the test {self._reported_by!r} failed and says why"
        pytest.skip(f"not run: {words}")

    def _require_property(self, name: str) -> None:
        """Fail where a property does not hold; skip where the arm has no such thing, such as collision shapes."""
        from urdf_ik.verify.testing import verdict

        report = self._report
        if isinstance(report, Exception):
            self._refuse(str(report), name)
        elif name != READABLE:
            holds, words = verdict(report, name)
            if holds is None:
                pytest.skip(words)
            if not holds:
                replay = [line for line in report.lines() if line.startswith("replay: ")]
                raise _Disagrees("\n".join([report.title(), words, self.given.definition, *replay]))

    def _require_unchanged(self, name: str, kind: str) -> None:
        """Fail where something of a kind differs from the lock, or where there is no lock."""
        import urdf_ik
        from urdf_ik.verify.baselines import replays
        from urdf_ik.verify.differences import summed

        given = self.given
        try:
            report = given.verification
        except urdf_ik.UrdfIkError as error:
            self._refuse(str(error), name)
            return
        if report is None:
            pytest.skip(f"no lock file {given.lock_path.name}, and --urdf-no-lock")
        if wrong := tuple(difference for difference in report.differences if difference.kind == kind):
            notes = [f"note: {note}" for note in report.notes if kind == "solutions"]
            lines = [
                f"{report.title()}: {kind}",
                *(f"  {line}" for line in (*summed(wrong), *notes)),
                given.definition,
                f"replay: lock = urdf_ik.verify.Lock.load({str(given.lock_path)!r})",
                *replays(wrong),
                f"if that is meant: urdf-ik verify {given.source} {given.lock_path.name} --update",
            ]
            raise _Disagrees("\n".join(lines))


class _Test(pytest.Item):
    """A test that fails with a sentence."""

    def __init__(self, *, check: Callable[[], None], **node: Any) -> None:
        super().__init__(**node)
        self._check = check

    def runtest(self) -> None:
        """Check."""
        self._check()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The check's own words instead of this module's source."""
        return str(excinfo.value) if isinstance(excinfo.value, _Disagrees) else super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where it comes from, and its heading."""
        return self.path, None, self.name


class _Disagrees(AssertionError):
    """A property does not hold."""


def _given(config: pytest.Config) -> list[_Given]:
    """Every ``--urdf``, the same objects whenever they are asked for."""
    if _KEPT not in config.stash:
        sources = config.getoption("--urdf")
        options = ("--base", "--tip", "--urdf-lock")
        values = [_one_each(config.getoption(option), option, len(sources)) for option in options]
        config.stash[_KEPT] = []
        for k, (source, base, tip, lock) in enumerate(zip(sources, *values, strict=True)):
            name = source if sources.count(source) == 1 else f"{source}[{base or tip or k}]"
            config.stash[_KEPT].append(_Given(config, name, source, (base, tip), lock))
    return config.stash[_KEPT]


_KEPT = pytest.StashKey[list[_Given]]()


def _one_each(values: list[str], option: str, n: int) -> list[str | None]:
    """One value for each of n arms."""
    if len(values) <= 1:
        return [values[0] if values else None] * n
    if len(values) != n:
        times = f"{option} is given {len(values)} times, --urdf {n} times"
        raise pytest.UsageError(f"{times}: one for all, or one for each")
    return list(values)
