"""Where long work is kept, and who does it."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Places:
    """A store and its workers as typed; None for what was not given.

    Attributes:
        store: folder to make the answer in.
        workers: number of processes on this machine that fill the store.
        scheduler: address of the scheduler whose workers do.
    """

    store: Path | None = None
    workers: int | None = None
    scheduler: str | None = None

    def check(self) -> None:
        """Refuse what cannot be.

        Raises:
            typer.BadParameter: two of these do not go together.
        """
        from urdf_ik.cli import console

        if self.workers is not None and self.scheduler is not None:
            raise console.usage("--scheduler has workers of its own: give it or --workers", "--workers")
        if self.store is None and (self.workers is not None or self.scheduler is not None):
            raise console.usage("workers fill a store: give --store FOLDER, too", "--workers")

    def client(self) -> AbstractContextManager[Any]:
        """The workers, for as long as the work takes; None for this process."""
        if self.workers is None and self.scheduler is None:
            return nullcontext()
        from urdf_ik.maps import engine

        return engine.connect(self.scheduler, self.workers)  # type: ignore[no-any-return]
