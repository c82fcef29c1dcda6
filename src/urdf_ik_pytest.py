"""Plugin of pytest: ``pytest --urdf FILE`` holds arms against Pinocchio and their lock files, one test a property.

Every pytest run in an environment with urdf-ik loads this module, so it stands outside the package and imports it only
where ``--urdf`` was given.

A lock file is ``FILE`` with the ending ``.lock.json``, beside it, or what ``--urdf-lock`` names. Tests of your own get
the arms and the locks by the fixtures ``arm`` and ``arm_lock``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.verify.baselines import Baseline, Verification
    from urdf_ik.verify.crosscheck import CrossCheck

MARK = "urdf"
READABLE = "can be read"
UNCHANGED = ("kinematics", "limits", "names", "collisions", "visuals", "solutions")
ENDING = ".lock.json"
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
def _urdf_ik_given(request: pytest.FixtureRequest) -> Given:
    given: Given = request.param
    return given


@pytest.fixture(scope="session")
def arm(_urdf_ik_given: Given) -> Arm:
    """The arm of ``--urdf``, each of them in turn."""
    return _urdf_ik_given.arm


@pytest.fixture(scope="session")
def arm_lock(_urdf_ik_given: Given) -> Baseline:
    """The lock of the arm of ``--urdf``; a test is skipped where there is none."""
    lock = _urdf_ik_given.lock
    if lock is None:
        pytest.skip(f"no lock file {_urdf_ik_given.lock_path}: pytest --urdf-freeze writes it")
    return lock


@pytest.hookimpl(tryfirst=True)  # before -k and -m choose
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the tests of every ``--urdf`` to what was collected."""
    for given in _given(config):
        checked = CheckedArm.from_parent(session, name=given.name, nodeid=given.name, given=given)
        items.extend(checked.collect())


class Given:
    """One ``--urdf`` with its links and its lock.

    Attributes:
        name: what its tests are called.
        source: as typed.
        lock_path: the lock file, which need not be there.
    """

    def __init__(self, config: pytest.Config, name: str, source: str, links: tuple[str | None, str | None],
                 lock: str | None) -> None:  # fmt: skip
        self.name, self.source = name, source
        self._links, self._freeze = links, config.getoption("--urdf-freeze")
        # pytest may run from elsewhere than where the command was typed.
        path = config.invocation_params.dir / source
        self._source: Path | str = path if path.is_file() else source
        beside = path.with_name(path.name.partition(".")[0] + ENDING)
        self.lock_path = config.invocation_params.dir / lock if lock else beside
        self._required = lock is not None

    @cached_property
    def arm(self) -> Arm:
        """The arm: base, tip and held joints as given, else those of the lock."""
        import urdf_ik

        base, tip = self._links
        held: dict[str, float] = {}
        if self.lock_path.is_file():
            lock = self._read()
            held = dict(lock.arm.locked)
            base, tip = (lock.arm.base if base is None else base), (lock.arm.tip if tip is None else tip)
        return urdf_ik.load(self._source, base=base, tip=tip, locked=held)

    @cached_property
    def lock(self) -> Baseline | None:
        """The lock, written first where it is missing and ``--urdf-freeze`` was given.

        Raises:
            ArgumentError: it is no lock file, or the one that was asked for is not there.
        """
        import urdf_ik

        if not self.lock_path.is_file() and self._freeze:
            urdf_ik.freeze(self.arm).save(self.lock_path)
        if not self.lock_path.is_file() and not self._required:
            return None
        return self._read()

    @cached_property
    def verification(self) -> Verification | None:
        """What of the lock holds; None without a lock."""
        return None if self.lock is None else self.lock.verify(self.arm)

    def _read(self) -> Baseline:
        from urdf_ik.verify.baselines import Baseline

        return Baseline.load(self.lock_path)


class CheckedArm(pytest.Collector):
    """One ``--urdf``: loaded and checked when the first of its tests runs."""

    def __init__(self, *, given: Given, **node: Any) -> None:
        super().__init__(**node)
        self.given = given
        self._reported_by = ""
        self.add_marker(MARK)

    def collect(self) -> Iterator[_Stated]:
        """One test a property of the cross-check and of the lock, and one for reading the file."""
        from urdf_ik.verify.crosscheck import PROPERTIES

        for name in (READABLE, *PROPERTIES):
            yield Property.from_parent(self, name=name)
        for kind in UNCHANGED:
            yield Unchanged.from_parent(self, name=f"unchanged {kind}", kind=kind)

    @cached_property
    def report(self) -> CrossCheck | Exception:
        """The cross-check's report, or why there is none."""
        import urdf_ik
        from urdf_ik.verify import crosscheck

        try:
            n, seed = (self.config.getoption(option) for option in ("--urdf-poses", "--urdf-seed"))
            return crosscheck.check(self.given.arm, n=n, seed=seed)
        except urdf_ik.UrdfIkError as error:
            return error

    def refuse(self, error: Exception, name: str) -> None:
        """Fail the first of the tests that runs with why there is no report, and skip the others: it is one fault.

        The test for reading the file may not be among those that were chosen, so any of them can be the first.
        """
        if self._reported_by in ("", name):
            self._reported_by = name
            raise _Disagrees(str(error))
        pytest.skip(
            f"not run: {self.given.source} cannot be read or checked; "
            f"the test {self._reported_by!r} failed and says why"
        )


class _Stated(pytest.Item):
    """A test that fails with a sentence."""

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The property's own words instead of this module's source."""
        if isinstance(excinfo.value, _Disagrees):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where it comes from, and its heading."""
        return self.path, None, self.name


class Property(_Stated):
    """One property of one arm."""

    def runtest(self) -> None:
        """Fail where it does not hold; skip where the arm has no such thing, such as collision shapes."""
        from urdf_ik.verify.testing import verdict

        assert isinstance(self.parent, CheckedArm)
        report = self.parent.report
        if isinstance(report, Exception):
            self.parent.refuse(report, self.name)
            return
        if self.name == READABLE:
            return
        holds, words = verdict(report, self.name)
        if holds is None:
            pytest.skip(words)
        if not holds:
            replay = [line for line in report.lines() if line.startswith("replay: ")]
            raise _Disagrees("\n".join([report.title(), words, *replay]))


class Unchanged(_Stated):
    """One kind of differences to the lock of one arm."""

    def __init__(self, *, kind: str, **node: Any) -> None:
        super().__init__(**node)
        self._kind = kind

    def runtest(self) -> None:
        """Fail where there is one; skip where there is no lock."""
        import urdf_ik
        from urdf_ik.verify.differences import summed

        assert isinstance(self.parent, CheckedArm)
        given = self.parent.given
        try:
            found = given.verification
        except urdf_ik.UrdfIkError as error:
            self.parent.refuse(error, self.name)
            return
        if found is None:
            pytest.skip(f"no lock file {given.lock_path.name}: pytest --urdf-freeze writes it")
        wrong = tuple(each for each in found.differences if each.kind == self._kind)
        if wrong:
            replay = dict.fromkeys(f"replay: {each.replay}" for each in wrong if each.replay)
            read = f"arm = urdf_ik.load({given.source!r}, {found.arm.base!r}, {found.arm.tip!r})"
            lock = f"lock = urdf_ik.verify.baselines.Baseline.load({str(given.lock_path)!r})"
            words = [*(f"  {line}" for line in summed(wrong)), *replay, f"with: {read}", f"      {lock}",
                     f"if that is meant: urdf-ik verify {given.source} {given.lock_path.name} --update"]  # fmt: skip
            raise _Disagrees("\n".join([f"{found.title()}: {self._kind}", *words]))


class _Disagrees(AssertionError):
    """A property does not hold."""


def _given(config: pytest.Config) -> list[Given]:
    """Every ``--urdf``, the same objects whenever they are asked for."""
    kept: list[Given] | None = config.stash.get(_KEPT, None)
    if kept is None:
        sources = config.getoption("--urdf")
        options = ("--base", "--tip", "--urdf-lock")
        each = [_one_each(config.getoption(option), option, len(sources)) for option in options]
        kept = config.stash[_KEPT] = []
        for k, (source, base, tip, lock) in enumerate(zip(sources, *each, strict=True)):
            name = source if sources.count(source) == 1 else f"{source}[{base or tip or k}]"
            kept.append(Given(config, name, source, (base, tip), lock))
    return kept


_KEPT = pytest.StashKey[list[Given]]()


def _one_each(given: list[str], option: str, n: int) -> list[str | None]:
    """One value for each of n arms."""
    if len(given) <= 1:
        return [given[0] if given else None] * n
    if len(given) != n:
        raise pytest.UsageError(f"{option} is given {len(given)} times, --urdf {n} times: one for all, or one for each")
    return list(given)
