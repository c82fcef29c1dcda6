"""Read-only arrays, and objects whose arrays stay read-only when pickled or copied (NumPy's copies are writeable)."""

import contextlib
import hashlib
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import UrdfIkError
from urdf_ik.support import files

_Number = TypeVar("_Number", bound=np.generic)


def frozen(array: NDArray[_Number]) -> NDArray[_Number]:
    """``array``, read-only: a view or a fresh array, never one that somebody else writes to."""
    array.setflags(write=False)
    return array


class Frozen:
    """An object whose arrays are all read-only, and stay so in its copies."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


def folder() -> Path:
    """The folder: ``urdf-ik`` in XDG_CACHE_HOME, in LOCALAPPDATA on Windows, or in ``~/.cache``."""
    parent = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(parent) if parent else Path("~/.cache").expanduser()) / "urdf-ik"


def arrays(
    kind: str, content: Sequence[bytes], compute: Callable[[], Mapping[str, NDArray[np.generic]]]
) -> Mapping[str, NDArray[np.generic]]:
    """The arrays that ``compute`` makes from some content; from the cache where it has them.

    Args:
        kind: what they are, with a version: a change of ``compute`` needs another.
        content: all that ``compute`` depends on.
        compute: makes them.
    """
    digest = hashlib.blake2b(digest_size=20)
    for part in content:
        digest.update(len(part).to_bytes(8, "little") + part)
    file = folder() / f"{kind}-{digest.hexdigest()}.npz"
    with contextlib.suppress(OSError, ValueError, zipfile.BadZipFile), np.load(file) as kept:
        return dict(kept)
    computed = compute()
    with contextlib.suppress(OSError, UrdfIkError):  # a home that cannot be written, a full disk
        file.parent.mkdir(parents=True, exist_ok=True)
        files.write(file, lambda target: np.savez(target, **computed))  # type: ignore[arg-type]
    return computed
