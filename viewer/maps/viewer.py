"""The viewer of maps: serves a map to many browsers, and runs selected cases."""

import hashlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from taichiflap import simulate
from taichiflap.case.case import Case
from taichiflap.case.solver import ELSEWHERE
from taichiflap.errors import UserError
from taichiflap.maps.file import open_map

from .. import camera
from ..explore.worker import Worker
from ..frames import UNREADABLE, Run
from ..server import Server
from ..watch import Watch
from .scene import BOX
from .session import MapSession

LOOK_SECONDS = 1.0
"""Interval between checks of the file, s."""


class MapViewer(Server):
    """Serves one map to any number of browsers.

    Args:
        path: the map file, complete or still being filled.
        host: the address to listen at; the default is this machine only.
        port: the port to listen at, or the first free one above it.
        token: whether the address contains a token that is required for access.

    Raises:
        ViewError: if the port or address is not available.
        MapError: if the file cannot be read.
    """

    def __init__(
        self, path: str | Path, host: str = "127.0.0.1", port: int = 8080, token: bool = True, trust: bool = False
    ) -> None:
        self.path, self.trust = Path(path), trust
        open_map(self.path).close()
        super().__init__(host, port, token)
        # Taichi needs one dedicated thread, for runs and for the flow around them.
        self.worker = ThreadPoolExecutor(1, thread_name_prefix="cases")
        self._explorer: Worker | None = None
        camera.start(self.server, BOX)
        self.serve(self._connect, self._disconnect, self._follow)

    def stop(self) -> None:
        """Stop serving after the current case."""
        super().stop()
        for session in self.sessions:
            session.close()
        self.worker.shutdown(wait=True, cancel_futures=True)
        if self._explorer:
            self._explorer.close()

    def explorer(self, case: Case) -> Worker:
        """The solver process for exploring cases of the map; started with the first."""
        with self._lock:
            if self._explorer is None or not self._explorer.alive:
                self._explorer = Worker(case)
            return self._explorer

    def run(self, number: int, progress: Callable[[int, int], None]) -> Run:
        """Case `number` of the map, from a file in a folder next to it; computed first if necessary.

        Raises:
            UserError: if the case is invalid, needs an untrusted module, or cannot be written.
        """
        with open_map(self.path) as sheet:
            case = sheet.design.case(sheet.case, number)
        if case.solver.startswith(ELSEWHERE) and not self.trust:
            raise UserError(
                f'case {number} runs the Python module of solver = "{case.solver}"; if you trust this map, view it '
                "with --trust"
            )
        digest = hashlib.sha256(case.to_toml().encode()).hexdigest()[:12]
        folder = self.path.with_name(f"{self.path.stem}-cases")
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise UserError(f"{folder}: cannot be created: {error.strerror}") from None
        result = simulate(case, folder / f"{number}-{digest}.h5", progress=progress, resume=True)
        return Run(result, f"case {number}")

    def _follow(self) -> None:
        """Inform browsers if the map is missing or unreadable twice in a row, since a study may be writing it."""
        watch, before = Watch(self.path, fixed=False), ""
        while not self._stop.wait(LOOK_SECONDS):
            trouble = watch.look() or self._read_error()
            for session in self.sessions:
                self._guard(session.warn, trouble if trouble == before else "")
            before = trouble

    def _read_error(self) -> str:
        try:
            open_map(self.path).close()
        except (UserError, *UNREADABLE) as error:
            return str(error)
        return ""

    def _connect(self, client: Any) -> None:
        session = MapSession(client, self.path, self.run, self.worker, self.explorer)
        if not self._welcome(client, session):
            session.close()

    def _disconnect(self, client: Any) -> None:
        session = self._take_leave(client)
        if session:
            session.close()
