"""Options of long work: the folder that keeps it, and the workers that do it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from typer import Option

from urdf_ik.cli import console, interrupts


@dataclass(frozen=True)
class StoreOptions:
    """A store and its workers as typed; None for what was not given."""

    GROUP: ClassVar[str] = "Store and workers"
    store: Annotated[
        Path | None, Option(metavar="FOLDER", help="Keep the work there; the same command continues it.")
    ] = None
    workers: Annotated[
        int | None, Option(metavar="N", min=1, help="Processes that fill the store (urdf-ik[scale]).")
    ] = None
    scheduler: Annotated[
        str | None,
        Option(metavar="ADDRESS", help="Dask scheduler of other workers, as tcp://HOST:PORT."),
    ] = None

    def check(self) -> None:
        """Refuse options that exclude each other.

        Raises:
            typer.BadParameter: two options exclude each other, or one needs another.
        """
        if self.workers is not None and self.scheduler is not None:
            raise console.usage("--scheduler has workers of its own: give it or --workers", "--workers")
        if self.store is None and (self.workers is not None or self.scheduler is not None):
            raise console.usage("workers fill a store: give --store FOLDER, too", "--workers")

    @contextmanager
    def client(self) -> Iterator[Any]:
        """The workers, for as long as the work takes; None for this process."""
        if self.workers is None and self.scheduler is None:
            yield None
            return
        from urdf_ik.maps import cluster

        client = interrupts.deaf_to_ctrl_c(lambda: cluster.connect(self.scheduler, self.workers))
        try:
            yield client
        except KeyboardInterrupt:
            raise  # the end of this process, which follows, ends the workers faster than closing them in order
        except BaseException:
            client.close()
            raise
        client.close()
