"""A shared library with the C interface of ``urdf_ik.h`` as a solver to judge."""

import ctypes
import os
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.typing import Array

_VALID = 1
_ERROR_BYTES = 1000
_NUMBERS = ctypes.POINTER(ctypes.c_double)
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "urdf_ik_load": (ctypes.c_void_p, (ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t)),
    "urdf_ik_joints": (ctypes.c_int, (ctypes.c_void_p,)),
    "urdf_ik_columns": (ctypes.c_int, (ctypes.c_void_p,)),
    "urdf_ik_solve": (
        ctypes.c_long,
        (ctypes.c_void_p, _NUMBERS, ctypes.c_long, _NUMBERS, ctypes.POINTER(ctypes.c_uint8), _NUMBERS, _NUMBERS),
    ),
    "urdf_ik_free": (None, (ctypes.c_void_p,)),
}


class CLibrary:
    """The solver of a compiled arm in a shared library: this package's own, or another one with the same functions.

    ``cmake -DBUILD_SHARED_LIBS=ON`` builds this package's; ``urdf-ik compile`` writes the arm.
    """

    def __init__(self, library: str | os.PathLike[str], arm: str | os.PathLike[str]) -> None:
        """Load the library and the arm.

        Raises:
            ArgumentError: one of them cannot be loaded, or the library lacks a function.
        """
        self.name = Path(library).name
        try:
            loaded = ctypes.CDLL(os.path.abspath(library))
        except OSError as error:
            raise ArgumentError(f"the library {printable(library)} cannot be loaded: {printable(error)}") from None
        self._call = {}
        for name, (result, arguments) in _FUNCTIONS.items():
            if not hasattr(loaded, name):
                raise ArgumentError(f"the library {printable(library)} has no function {name}; see urdf_ik.h")
            function = getattr(loaded, name)
            function.restype, function.argtypes = result, arguments
            self._call[name] = function
        reason = ctypes.create_string_buffer(_ERROR_BYTES)
        self._arm = self._call["urdf_ik_load"](os.fsencode(arm), reason, _ERROR_BYTES)
        if not self._arm:
            raise ArgumentError(printable(reason.value.decode(errors="replace"), _ERROR_BYTES))
        self._shape = self._call["urdf_ik_columns"](self._arm), self._call["urdf_ik_joints"](self._arm)

    def __call__(self, T: Array) -> Array:
        """Joint vectors (k, joints) of a pose (4, 4), redundancy parameters at their defaults."""
        target = np.ascontiguousarray(T, dtype=np.float64)
        q, flags = np.empty(self._shape), np.empty(self._shape[0], np.uint8)
        bad = self._call["urdf_ik_solve"](
            self._arm,
            target.ctypes.data_as(_NUMBERS),
            1,
            q.ctypes.data_as(_NUMBERS),
            flags.ctypes.data_as(ctypes.POINTER(ctypes.c_uint8)),
            None,
            None,
        )
        return q[:0] if bad >= 0 else q[flags & _VALID != 0]

    def __del__(self) -> None:
        if getattr(self, "_arm", None):
            self._call["urdf_ik_free"](self._arm)
