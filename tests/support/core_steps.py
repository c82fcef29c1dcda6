"""The steps of the compiled solvers, one by one: the module that is built beside the core for tests."""

import importlib.util
import sysconfig
from pathlib import Path
from types import ModuleType

from urdf_ik import _core

FOLDER = Path(str(_core.__file__)).parent
"""Where the core was built, and what tests alone use with it."""


def _loaded() -> ModuleType:
    """The module beside the core."""
    path = FOLDER / f"_core_steps{sysconfig.get_config_var('EXT_SUFFIX')}"
    if not path.is_file():
        raise ImportError(f"{path} is missing: `make test` builds it, CMake with -DURDF_IK_TESTS=ON")
    spec = importlib.util.spec_from_file_location("_core_steps", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_steps = _loaded()
step, polish = _steps.step, _steps.polish
