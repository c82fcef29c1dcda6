"""The examples of docstrings print what they show."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

import urdf_ik

# The package's own folder: the path of an editable install holds others, where the bundled URDFs come from.
FOLDER = str(Path(urdf_ik.__file__).parent)
NAMES = ["urdf_ik", *(module.name for module in pkgutil.walk_packages([FOLDER], "urdf_ik."))]
# What is imported by users: the package and its rooms, not the modules inside a room.
# The rooms, and the packages in them whose lists of names are public.
PACKAGES = [module.name for module in pkgutil.walk_packages([FOLDER], "urdf_ik.") if module.ispkg]
FILES = [f"urdf_ik.{module.name}" for module in pkgutil.iter_modules([FOLDER]) if not module.ispkg]
FILES += [
    f"urdf_ik.{name}"
    for name in ("cell.pinocchio_reference", "ik.cuspidality", "ik.tasks", "kinematics.velocity", "model.catalogue",
                 "model.poses", "verify.testing")
]  # fmt: skip
ROOMS = ["urdf_ik", *PACKAGES, *(name for name in FILES if name != "urdf_ik._core")]

# No example of these can run here: name, or name of the class, to the reason.
WITHOUT_EXAMPLE = {
    "urdf_ik.cli.main": "the command itself: it reads sys.argv and ends the process",
    "urdf_ik.ik.cuspidality.nonsingular_change": "searches for seconds, and finds nothing on the bundled arms",
    "urdf_ik.interop.other_programs.ViserArm": "moves what a page on a port shows",
    "urdf_ik.interop.other_programs.add_to_viser": "adds to the scene of a page on a port",
    "urdf_ik.show.plot.slider_panel.interact": "sliders of a notebook, which has to be open",
    "urdf_ik.show.plot.slider_panel.show": "opens a window, and waits until somebody closes it",
    "urdf_ik.show.viewer.page.Viewer": "serves a page on a port, for a browser",
}


def examples_of(name: str) -> list[doctest.DocTest]:
    """The examples of a module, without what it imports from others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module = importlib.import_module(name)
    return [test for test in doctest.DocTestFinder().find(module, name) if test.examples]


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith(("__main__", "_core"))])
def test_examples(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every example of a module runs, in a folder of its own, and prints what stands below it."""
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    printed: list[str] = []
    for test in examples_of(name):
        runner.run(test, out=printed.append)
    assert not runner.failures, "".join(printed)


# A method that passes on names the function that has its arguments and its example.
SHOWN_ELSEWHERE = re.compile(r"([Ss]ee|example:)\s+:(func|meth):`([\w.]+)`")


def public() -> Iterator[tuple[str, str]]:
    """Public functions and methods: full name, and docstring with that of what it overrides.

    Those are what a room names in ``__all__``, functions where it has none, and the public methods of these classes.
    """
    for name in ROOMS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            room = importlib.import_module(name)
        own = [key for key, value in vars(room).items() if inspect.isfunction(value) and value.__module__ == name]
        for key in getattr(room, "__all__", [key for key in own if not key.startswith("_")]):
            value = getattr(room, key)
            if inspect.isfunction(value):
                yield f"{value.__module__}.{value.__qualname__}", value.__doc__ or ""
            elif inspect.isclass(value):
                yield from methods(value)


def methods(owner: type) -> Iterator[tuple[str, str]]:
    """The public methods of a class, inherited ones included; properties are shown by their class's examples."""
    for key in dir(owner):
        # As written in the class: a method of a class or without one is a function behind its decorator.
        versions = [
            getattr(vars(each)[key], "__func__", vars(each)[key])
            for each in owner.__mro__
            if key in vars(each) and each.__module__.startswith("urdf_ik.")
        ]
        if not key.startswith("_") and versions and inspect.isfunction(versions[0]):
            text = "".join(version.__doc__ or "" for version in versions)
            yield f"{versions[0].__module__}.{versions[0].__qualname__}", text


def test_every_public_function_has_an_example() -> None:
    """Each public function and method shows its use, itself or in the method that it overrides."""
    found = dict(public())
    assert len(found) > 200
    missing = [
        name
        for name, text in found.items()
        if not (">>>" in text or SHOWN_ELSEWHERE.search(text) or {name, name.rpartition(".")[0]} & set(WITHOUT_EXAMPLE))
    ]
    assert not missing, "\n".join(sorted(missing))


def test_every_class_of_the_package_has_an_example() -> None:
    """Each class that the package itself names shows what it is for; errors do where they hold more than a message."""
    classes = [value for value in (getattr(urdf_ik, name) for name in urdf_ik.__all__) if inspect.isclass(value)]
    missing = [
        each.__name__
        for each in classes
        if ">>>" not in (each.__doc__ or "")
        and not (issubclass(each, urdf_ik.UrdfIkError) and "__init__" not in vars(each))
    ]
    assert not missing, "\n".join(missing)


def test_exceptions_are_needed() -> None:
    """What is listed as without an example exists, and has none."""
    found = dict(public())
    for name in WITHOUT_EXAMPLE:
        texts = [text for each, text in found.items() if each == name or each.rpartition(".")[0] == name]
        assert texts and not any(">>>" in text for text in texts), name
