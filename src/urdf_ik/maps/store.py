"""BlockStore: arrays over a grid in a Zarr group, written block by block by this process or by Dask's workers.

A block of an array is one chunk. Zarr writes a chunk under a temporary name and renames it, so a chunk that exists is
whole, also after SIGKILL. The arrays of a block are written in their order: a block is done when its chunk of the last
array exists, and a run continues with the others. A block depends on nothing but the question in the group's
attributes, so two runs of one store write the same bytes, and neither needs a lock. Each chunk ends with a CRC-32C
checksum that every Zarr reader checks.
"""

import contextlib
import hashlib
import os
import shutil
import uuid
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, JobError, printable
from urdf_ik.maps import cluster
from urdf_ik.maps.grid import AXES, Blocks, Grid, Part

FORMAT, VERSION = "urdf-ik workspace map in Zarr", 2
_LEVEL = 1  # of Zstandard: a higher one takes longer than solving and saves little

STORE_KEYS = ("format", "version", "block", "complete")
"""What a store's attributes hold besides the question."""

Progress = Callable[[int, int], object]
Pairs = tuple[tuple[str, str], ...]


class Variable(NamedTuple):
    """An array of a map.

    Attributes:
        kind: type of its numbers.
        last: name of its dimension after x, y and z.
        words: description of the numbers.
        units: of the numbers; '1' without a unit.
    """

    kind: type[np.generic]
    last: str
    words: str
    units: str = "1"

    @property
    def fill(self) -> float:
        """The value where nothing is written: NaN for measured values, else 0."""
        return float("nan") if self.kind is np.float32 else 0

    @property
    def attributes(self) -> dict[str, str]:
        """The array's attributes."""
        return {"long_name": self.words, "units": self.units}


VARIABLES = {
    "solutions": Variable(np.uint8, "orientation", "number of solutions"),
    "within": Variable(np.uint8, "orientation", "number of solutions within the limits"),
    "free": Variable(np.uint8, "orientation", "number of solutions within the limits and free of collision"),
    "manipulability": Variable(np.float32, "orientation", "greatest manipulability of the solutions that count"),
    "margin": Variable(np.float32, "orientation", "greatest limit margin of the solutions that count"),
    "clearance": Variable(np.float32, "orientation", "greatest clearance of the solutions that count", "m"),
    "branch_poses": Variable(
        np.uint16, "branch", "number of orientations in which a branch has a solution that counts"
    ),
}
"""The arrays that a map can contain."""

Coordinate = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]
"""Names of dimensions, values and attributes, as xarray takes them."""


def about_arm(arm: Arm, pairs: Pairs | None, world: World | None) -> dict[str, Any]:
    """The arm and the cell of a question in JSON; ``pairs``: those that are checked, None without collisions."""
    return {
        "robot": arm.name,
        "urdf_sha256": digest(arm.model.xml),
        "base": arm.base,
        "tip": arm.tip,
        "locked": dict(arm.chain.locked),
        "pairs_sha256": None if pairs is None else digest(repr(pairs).encode()),
        "world": None if world is None else world.digest(),
        "made_by": cluster.versions()["urdf-ik"],
    }


def digest(data: bytes) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


class BlockStore:
    """A Zarr group whose arrays are read and written block by block.

    Args:
        path: the group's folder.

    Attributes:
        path: the folder.
        question: the question in JSON.
        grid: the voxels.
        blocks: the division of the grid.
        names: names of the arrays over the grid.
        group: the ``zarr.Group``.

    Raises:
        JobError: there is no such store.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        zarr = cluster.package("zarr")
        try:
            with zarr.config.set({"array.write_empty_chunks": True}):  # or a block of zeros would have no chunk
                self.group = zarr.open_group(str(self.path), mode="r+", zarr_format=3)
                self.question = dict(self.group.attrs)
                stored = self.question.get("format"), self.question.get("version")
                if stored != (FORMAT, VERSION):
                    raise JobError(
                        f"{path} is {stored[0]!r}, version {stored[1]}; {FORMAT!r}, version {VERSION} is read"
                    )
                self.names: tuple[str, ...] = tuple(self.question["holds"])
                self._arrays = {name: self.group[name] for name in self.names}
            self.grid = Grid.from_described(self.question["grid"])
            x, y, z = self.question["block"]
            self.blocks = Blocks(self.grid.shape, (x, y, z))
        except (OSError, KeyError, TypeError, ValueError) as error:
            raise JobError(f"{path} is no store of this package: {error}") from None

    @property
    def about(self) -> dict[str, Any]:
        """The question without what only stores have."""
        return {name: value for name, value in self.question.items() if name not in STORE_KEYS}

    def is_done(self, block: int) -> bool:
        """Whether a block's chunk of the last array exists."""
        return self.path.joinpath(self.names[-1], "c", *map(str, self.blocks.place(block)), "0").exists()

    def pending(self) -> list[int]:
        """The blocks that are not done."""
        return [block for block in range(self.blocks.count) if not self.is_done(block)]

    def array(self, name: str, part: Part) -> NDArray[Any]:
        """One array in a box of voxels.

        Raises:
            JobError: a block is not done, or damaged.
        """
        blocks = self.blocks.overlapping(part)
        missing = sum(not self.is_done(block) for block in blocks)
        if missing:  # Zarr would read a missing chunk as zeros
            raise JobError(
                f"{self.path} is not complete: {missing} of the {len(blocks)} blocks that are needed are missing; run "
                "what computes the map again, with the same store"
            )
        try:
            return np.asarray(self._arrays[name][part])
        except Exception as error:  # Zarr and its codecs have many errors for damaged bytes
            marks = self.path / self.names[-1] / "c"
            raise JobError(
                f"{self.path}: {name} is damaged ({error}); delete {marks} and run again: all blocks are computed anew"
            ) from None

    def write(self, block: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write the arrays of a block, in their order."""
        part = self.blocks.part(block)
        for name in self.names:
            self._arrays[name][part] = arrays[name]


def fill(path: str | os.PathLike[str], question: Any, client: Any, progress: Progress | None, units: int) -> BlockStore:
    """Compute all blocks that a store lacks; a missing store is created.

    Args:
        path: folder of the store.
        question: the question, a ``maps.workspaces.creation.Question``.
        client: a ``distributed.Client`` whose workers compute the blocks; None for this process.
        progress: called with the number of finished units, and of all.
        units: their number.

    Raises:
        JobError: the folder is no store, or one of another question; the blocks do not fit on the disk; or the
            scheduler or the workers cannot go on. Finished blocks are kept.
        KeyboardInterrupt: Ctrl-C. Finished blocks are kept.
    """
    folder = _checked(path)
    blocks = question.blocks
    asked = {"format": FORMAT, "version": VERSION, "block": list(blocks.shape), **question.described()}
    if not (folder / "zarr.json").exists():
        _create(folder, question, asked)
    store = BlockStore(folder)
    _require_same(store, asked)
    pending = store.pending()
    done = blocks.count - len(pending)

    def tick() -> None:
        if progress is not None:
            progress(done * units // blocks.count, units)

    tick()
    here = ((block, question.solved(blocks.part(block))) for block in pending)
    results = here if client is None else cluster.results(question, pending, client)
    try:
        for block, arrays in results if pending else ():
            try:
                store.write(block, arrays)
            except OSError as error:
                raise JobError(
                    f"cannot write {folder}: {error.strerror}; {done} of {blocks.count} blocks are kept, and the same "
                    "run continues when it can write"
                ) from None
            done += 1
            tick()
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; {done} of {blocks.count} blocks are kept in {folder}, and the same run continues from there"
        ) from None
    if not store.question["complete"]:
        store.group.attrs["complete"] = True
    return store


def _checked(path: str | os.PathLike[str]) -> Path:
    """The folder of a store to be created or continued."""
    folder = Path(path)
    if ":/" in str(path) or not folder.absolute().parent.is_dir():
        raise JobError(f"{path}: a store is a folder on a disk, in a folder that is there")
    if folder.exists() and not (folder / "zarr.json").exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise JobError(f"{path} exists, and is no store of this package; give another path")
    return folder


def _create(folder: Path, question: Any, asked: dict[str, Any]) -> None:
    """Create the group without blocks, under a temporary name first."""
    zarr, codecs = cluster.package("zarr"), cluster.package("zarr.codecs")
    packing = [codecs.ZstdCodec(level=_LEVEL), codecs.Crc32cCodec()]
    new = folder.absolute().parent / f".{folder.name}.{uuid.uuid4().hex}"
    blocks, grid = question.blocks, question.grid
    try:
        group = zarr.create_group(str(new), zarr_format=3, attributes={**asked, "complete": False})
        for name, (dimensions, values, attributes) in question.coordinates.items():
            group.create_array(
                name, data=values, dimension_names=dimensions, compressors=packing, attributes=attributes
            )
        for name in question.names:
            variable = VARIABLES[name]
            group.create_array(
                name,
                shape=question.shape(name, grid.shape),
                chunks=question.shape(name, blocks.shape),
                dtype=np.dtype(variable.kind).name,
                fill_value=variable.fill,
                dimension_names=(*AXES, variable.last),
                compressors=packing,
                attributes=variable.attributes,
            )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # other readers that do not know consolidated metadata read the arrays' own
            zarr.consolidate_metadata(str(new))
        new.rename(folder)
    except OSError as error:
        shutil.rmtree(new, ignore_errors=True)
        if not (folder / "zarr.json").exists():  # or another run created it meanwhile
            raise JobError(f"cannot write {folder}: {error.strerror}") from None


def _require_same(store: BlockStore, asked: dict[str, Any]) -> None:
    """Refuse a store of another question, with what differs."""
    stored = {name: value for name, value in store.question.items() if name != "complete"}
    differing = [
        f"{name} is {printable(stored.get(name), 120)} in the store and {printable(asked.get(name), 120)} now"
        for name in {**asked, **stored}
        if stored.get(name) != asked.get(name)
    ]
    if differing:
        words = "; ".join(differing[:4])
        raise JobError(f"{store.path} contains another map: {words}; give another path, or ask as before")


def available_memory() -> int:
    """Bytes of memory that are free without swapping."""
    import psutil  # only long work needs it

    free = [int(psutil.virtual_memory().available)]
    group = Path("/sys/fs/cgroup")
    with contextlib.suppress(OSError, ValueError):  # a container's own limit, where there is one
        free.append(int((group / "memory.max").read_text()) - int((group / "memory.current").read_text()))
    return max(0, min(free))


def require_memory(needed: int, what: str, hint: str) -> None:
    """Refuse a result that does not fit in memory, before any work.

    Args:
        needed: size of the result [bytes].
        what: the results and their number, in the plural.
        hint: a change that makes it fit.

    Raises:
        ArgumentError: it does not fit; with the numbers.
    """
    free = available_memory()
    if needed > free:
        raise ArgumentError(f"{what} take {size_text(needed)} of memory, and {size_text(free)} are free; {hint}")


def size_text(count: int) -> str:
    """A number of bytes in GiB or MiB."""
    return f"{count / 2**30:.3g} GiB" if count >= 2**29 else f"{count / 2**20:.3g} MiB"
