"""The models of robot_descriptions, which that package downloads at first use."""

import contextlib
import io
import os
import sys
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from urdf_ik.errors import ArgumentError

_ENDINGS = ("_description", "_mj_description")
_ARMS = {"arm", "dual_arm", "mobile_manipulator"}


def names() -> tuple[str, ...]:
    """Names of the models that have arms, () where robot_descriptions is not installed."""
    return tuple(sorted(name for name, facts in _descriptions().items() if facts.tags & _ARMS))


def model_of(name: str) -> str | None:
    """The model that a name means: itself, or with ``_description`` or ``_mj_description``; None for no model."""
    known = _descriptions()
    return next((each for each in (name, *(name + ending for ending in _ENDINGS)) if each in known), None)


def describe(model: str) -> str:
    """Maker and name of a model's robot."""
    facts = _descriptions()[model]
    return " ".join(filter(None, (facts.maker, facts.robot)))


def joints_of(model: str) -> int | None:
    """Number of a model's joints, where robot_descriptions says so."""
    return _descriptions()[model].dof  # type: ignore[no-any-return]


def is_here(name: str) -> bool:
    """Whether the files of a model have been downloaded."""
    if (source := repository_of(name)) is None:
        return False
    from robot_descriptions._repositories import REPOSITORIES

    if (repository := REPOSITORIES.get(source)) is None:
        return False
    folder = cache_folder() / repository.cache_path
    return folder.is_dir() and any(each.name != ".git" for each in folder.iterdir())


def cache_folder() -> Path:
    """The folder of the downloaded repositories."""
    return Path(os.environ.get("ROBOT_DESCRIPTIONS_CACHE", "~/.cache/robot_descriptions")).expanduser().resolve()


def repository_of(name: str) -> str | None:
    """The repository that a model comes from, None for no model."""
    model = model_of(name)
    return None if model is None else str(_descriptions()[model].repository)


def fetch(model: str, instead: str) -> tuple[Path, tuple[Path, ...], Mapping[str, str] | None]:
    """Where a model's files are, after a download where they have not been here.

    Args:
        model: its name.
        instead: what the error says of a model that cannot be downloaded.

    Returns:
        Its URDF, xacro or MJCF, the folders of its packages and meshes, and the arguments of a xacro.
    """
    try:
        if not is_here(model):
            print(f"downloading {model} from {repository_of(model)}", file=sys.stderr)
        with contextlib.redirect_stdout(sys.stderr), contextlib.redirect_stderr(io.StringIO()):  # bars of the clone
            module = import_module(f"robot_descriptions.{model}")
    except Exception as error:  # git's own errors, and those of an installation without git
        said = " ".join(str(getattr(error, "stderr", "") or error).split()).removeprefix("stderr: ")
        raise ArgumentError(
            f"{model!r} is not on this machine, and robot_descriptions could not download it; without a network give a "
            f"file: urdf-ik info arm.urdf ({instead}). Git said: {said[:300]}"
        ) from None
    for attribute in ("URDF_PATH", "XACRO_PATH", "MJCF_PATH"):
        if path := getattr(module, attribute, None):
            others = getattr(module, "XACRO_PACKAGE_PATHS", {}).values()
            folders = [module.PACKAGE_PATH, module.REPOSITORY_PATH, *others]
            folders += [os.path.dirname(folder) for folder in folders]
            arguments = getattr(module, "XACRO_ARGS", {}) if attribute == "XACRO_PATH" else None
            return Path(path), tuple(dict.fromkeys(map(Path, folders))), arguments
    raise ArgumentError(f"{model!r} of robot_descriptions is neither URDF nor xacro nor MJCF")


@cache
def _descriptions() -> Mapping[str, Any]:
    """The models that robot_descriptions lists, {} if it is not installed."""
    try:
        from robot_descriptions import DESCRIPTIONS
    except ImportError:
        return {}
    known: Mapping[str, Any] = DESCRIPTIONS
    return known
