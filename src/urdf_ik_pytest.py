"""Plugin of pytest: ``pytest --urdf FILE`` holds arms against Pinocchio, one test a property.

Every pytest run in an environment with urdf-ik loads this module, so it stands outside the package and imports it only
where ``--urdf`` was given.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from urdf_ik.verify.crosscheck.report import Report

MARK = "urdf"
READABLE = "can be read"


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options."""
    group = parser.getgroup("urdf-ik", "urdf-ik: arms against Pinocchio")
    repeated: dict[str, Any] = {"action": "append", "default": []}
    group.addoption("--urdf", metavar="FILE", help="cross-check this URDF or catalogue name; repeatable", **repeated)
    group.addoption("--base", metavar="LINK", help="base link: one for all, or one for each --urdf", **repeated)
    group.addoption("--tip", metavar="LINK", help="tip link: one for all, or one for each --urdf", **repeated)
    group.addoption("--urdf-poses", metavar="N", type=int, default=200, help="random poses for each --urdf")
    group.addoption("--urdf-seed", metavar="SEED", type=int, default=0, help="seed of the random poses")


def pytest_configure(config: pytest.Config) -> None:
    """Make the mark known, by which the tests can be chosen: ``-m urdf``."""
    config.addinivalue_line("markers", f"{MARK}: a cross-check that --urdf asked for")


@pytest.hookimpl(tryfirst=True)  # before -k and -m choose
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the tests of every ``--urdf`` to what was collected."""
    sources = config.getoption("--urdf")
    links = [_one_each(config.getoption(option), option, len(sources)) for option in ("--base", "--tip")]
    for k, (source, base, tip) in enumerate(zip(sources, *links, strict=True)):
        name = source if sources.count(source) == 1 else f"{source}[{base or tip or k}]"
        checked = CheckedArm.from_parent(session, name=name, nodeid=name, source=source, base=base, tip=tip)
        items.extend(checked.collect())


class CheckedArm(pytest.Collector):
    """One ``--urdf``: loaded and checked when the first of its tests runs."""

    def __init__(self, *, source: str, base: str | None, tip: str | None, **node: Any) -> None:
        super().__init__(**node)
        self._given = source, base, tip
        self._reported_by = ""
        self.add_marker(MARK)

    def collect(self) -> Iterator[Property]:
        """One test a property of the cross-check, and one for reading the file."""
        from urdf_ik.verify.crosscheck import PROPERTIES

        for name in (READABLE, *PROPERTIES):
            yield Property.from_parent(self, name=name)

    @cached_property
    def report(self) -> Report | Exception:
        """The cross-check's report, or why there is none."""
        import urdf_ik
        from urdf_ik.verify import crosscheck

        source, base, tip = self._given
        # pytest may run from elsewhere than where the command was typed.
        path = self.config.invocation_params.dir / source
        try:
            arm = urdf_ik.load(path if path.is_file() else source, base=base, tip=tip)
            n, seed = (self.config.getoption(option) for option in ("--urdf-poses", "--urdf-seed"))
            return crosscheck.check(arm, n=n, seed=seed)
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
            f"not run: {self._given[0]} cannot be read or checked; the test {self._reported_by!r} failed and says why"
        )


class Property(pytest.Item):
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
            replay = [line for line in report.remarks() if line.startswith("replay: ")]
            raise _Disagrees("\n".join([report.title(), words, *replay]))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The property's own words instead of this module's source."""
        if isinstance(excinfo.value, _Disagrees):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where it comes from, and its heading."""
        return self.path, None, self.name


class _Disagrees(AssertionError):
    """A property does not hold."""


def _one_each(given: list[str], option: str, n: int) -> list[str | None]:
    """One value for each of n arms."""
    if len(given) <= 1:
        return [given[0] if given else None] * n
    if len(given) != n:
        raise pytest.UsageError(f"{option} is given {len(given)} times, --urdf {n} times: one for all, or one for each")
    return list(given)
