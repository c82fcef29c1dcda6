"""BlockStore: arrays over a grid in a Zarr group, written block by block by this process or by Dask's workers.

A block of an array is one chunk. Zarr writes a chunk under a temporary name and renames it, so a chunk that exists is
whole, also after SIGKILL. The arrays of a block are written in their order: a block is done when its chunk of the last
array exists, and a run continues with the others. A block depends on nothing but the question in the group's
attributes, so two runs of one store write the same bytes, and neither needs a lock. Each chunk ends with a CRC-32C
checksum that every Zarr reader checks.
"""

import contextlib
import hashlib
import math
import os
import shutil
import uuid
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.arm import Arm
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, JobError, printable
from urdf_ik.maps import cluster
from urdf_ik.maps.grid import AXES, Blocks, Grid, Part

VERSION = 2
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


Coordinate = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]
"""Names of dimensions, values and attributes, as xarray takes them."""


@dataclass(frozen=True, eq=False)
class Question:
    """All that the arrays of a map depend on; pickled for workers.

    Attributes:
        arm: the arm.
        world: obstacles, or None.
        grid: the voxels.
        names: names of the requested arrays, some of ``VARIABLES``.
        most: greatest number of voxels of a block.
        threads: number of threads that solve.
        pairs: pairs of links that are checked for collision; None without a collision check.
        lengths: lengths of the dimensions after x, y and z, by name.
    """

    FORMAT: ClassVar[str]
    VARIABLES: ClassVar[Mapping[str, Variable]]

    arm: Arm
    world: World | None
    grid: Grid
    names: tuple[str, ...]
    most: int
    threads: int
    pairs: Pairs | None
    lengths: Mapping[str, int]

    @property
    def blocks(self) -> Blocks:
        """The division of the grid."""
        return Blocks.cut(self.grid.shape, self.most)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """The arrays that say what the places along the dimensions are."""
        words = {"units": "m", "long_name": "voxels' centres"}
        return {name: ((name,), self.grid.coordinates(k), words) for k, name in enumerate(AXES)}

    def solved(self, part: Part) -> dict[str, NDArray[Any]]:
        """The arrays of a box of voxels."""
        raise NotImplementedError

    def shape(self, name: str, positions: tuple[int, ...]) -> tuple[int, ...]:
        """Shape of an array at positions of some shape."""
        return (*positions, self.lengths[self.VARIABLES[name].last])

    def size(self, positions: int) -> int:
        """Size of all arrays at so many positions [bytes]."""
        return sum(
            math.prod(self.shape(name, (positions,))) * np.dtype(self.VARIABLES[name].kind).itemsize
            for name in self.names
        )

    def described(self) -> dict[str, Any]:
        """The question in JSON, for a store."""
        versions = {"instructions": cluster.versions()["instructions"]}
        about = about_arm(self.arm, self.pairs, self.world) | versions
        return about | {"grid": self.grid.described(), "holds": list(self.names)}

    def computed(self, progress: Progress | None, units: int) -> dict[str, NDArray[Any]]:
        """All arrays in memory, block by block, read-only; ``progress``: finished units, and their number."""
        arrays: dict[str, NDArray[Any]] = {
            name: np.empty(self.shape(name, self.grid.shape), self.VARIABLES[name].kind) for name in self.names
        }
        for done, part in enumerate(self.blocks.parts(), 1):
            for name, values in self.solved(part).items():
                arrays[name][part] = values
            if progress is not None:
                progress(done * units // self.blocks.count, units)
        for array in arrays.values():
            array.setflags(write=False)
        return arrays

    def __setstate__(self, state: dict[str, Any]) -> None:
        # A pickled arm has no collision model; the copy builds a new one, which needs the pairs that are checked.
        self.__dict__.update(state)
        if self.pairs is not None:
            cell = self.arm.cell
            self.__dict__["arm"] = self.arm.with_cell(cell.with_collisions(cell.collisions.checking(self.pairs)))


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
        form: the group's format, ``FORMAT`` of its question.

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

    def __init__(self, path: str | os.PathLike[str], form: str) -> None:
        self.path = Path(path)
        zarr = cluster.package("zarr")
        try:
            with zarr.config.set({"array.write_empty_chunks": True}):  # or a block of zeros would have no chunk
                self.group = zarr.open_group(str(self.path), mode="r+", zarr_format=3)
                self.question = dict(self.group.attrs)
                stored = self.question.get("format"), self.question.get("version")
                if stored != (form, VERSION):
                    raise JobError(f"{path} is {stored[0]!r}, version {stored[1]}; {form!r}, version {VERSION} is read")
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


def fill(
    path: str | os.PathLike[str], question: Question, client: Any, progress: Progress | None, units: int
) -> BlockStore:
    """Compute all blocks that a store lacks; a missing store is created.

    Args:
        path: folder of the store.
        question: the question.
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
    asked = {"format": question.FORMAT, "version": VERSION, "block": list(blocks.shape), **question.described()}
    store = BlockStore(folder, question.FORMAT) if (folder / "zarr.json").exists() else None
    if store is not None:
        _require_same(store, asked)
    pending = list(range(blocks.count)) if store is None else store.pending()
    if store is None:
        _create(folder, question, asked)
        store = BlockStore(folder, question.FORMAT)
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


def _create(folder: Path, question: Question, asked: dict[str, Any]) -> None:
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
            variable = question.VARIABLES[name]
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
