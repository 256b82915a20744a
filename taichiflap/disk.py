"""How files get their names and who may write them: synced before they are renamed, and locked by a file of our own.

HDF5's own lock is often switched off where it matters, on NFS and Lustre. `NAME.lock` names the host and the process
that writes NAME; one whose process is gone is taken over.
"""

import contextlib
import os
import socket
from pathlib import Path

SUFFIX = ".lock"
LONGEST_NAME = 224
"""Bytes of a file's name: drafts and locks beside it have longer ones, and 255 is the most that systems take."""


class Busy(Exception):
    """Another process writes the file: who, and what to do if it does not."""


def trouble(path: Path) -> str:
    """Why nothing can be written under a name, before anything is computed for it; nothing if all is well."""
    if len(os.fsencode(path.name)) > LONGEST_NAME:
        return f"a name of {len(os.fsencode(path.name))} bytes; give one of at most {LONGEST_NAME}"
    try:
        path.stat()
    except FileNotFoundError:
        return "is a link to nothing; remove it, or name another file" if path.is_symlink() else ""
    except NotADirectoryError:
        return ""  # told of its folder
    except OSError as error:
        return f"cannot be written: {error.strerror}"
    return ""


def sync(path: Path) -> None:
    """Have the system put a file on the disk before anything counts on it.

    Raises:
        OSError: when the disk refuses.
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def replace(source: Path, target: Path) -> None:
    """Rename a file, synced, in the place of another or not.

    Raises:
        OSError: when the system refuses.
    """
    sync(source)
    os.replace(source, target)


class Lock:
    """The right to write a file, until `release`.

    Raises:
        Busy: when another process has it.
        OSError: when there can be no file beside the one to write.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.with_name(path.name + SUFFIX)
        self._ours = _sign()
        for _ in range(3):
            if self._create():
                return
            theirs = self._read()
            if theirs is None:
                continue  # released in the meantime
            if not _gone(theirs):
                host, process, *_ = [*theirs.split(), "?", "?"]
                raise Busy(f"process {process} on {host}; if there is none, remove {self.path}")
            self._take_away(theirs)
        raise Busy(f"see {self.path}")

    def release(self) -> None:
        """Let others write. Twice does no harm."""
        with contextlib.suppress(OSError):
            if self._read() == self._ours:
                self.path.unlink()

    def _create(self) -> bool:
        """Put our name there, whole at once; whether nobody was before us."""
        draft = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            draft.write_text(self._ours)
            try:
                os.link(draft, self.path)
            except FileExistsError:
                return False
            except OSError:  # a file system without links
                try:
                    with open(self.path, "x") as file:
                        file.write(self._ours)
                except FileExistsError:
                    return False
            return True
        finally:
            with contextlib.suppress(OSError):
                draft.unlink()

    def _read(self) -> str | None:
        try:
            with open(self.path, "rb") as file:
                return file.read(1024).decode(errors="replace")
        except FileNotFoundError:
            return None

    def _take_away(self, theirs: str) -> None:
        """Remove the lock of a process that is gone, unless another has just done so."""
        aside = self.path.with_name(f".{self.path.name}.{os.getpid()}.stale")
        with contextlib.suppress(FileNotFoundError):
            os.rename(self.path, aside)
            if aside.read_text(errors="replace") != theirs:
                with contextlib.suppress(OSError):
                    os.link(aside, self.path)
            aside.unlink()


def _sign() -> str:
    return f"{socket.gethostname()} {os.getpid()} {_began(os.getpid())}\n"


def _gone(theirs: str) -> bool:
    """Whether a lock is of a process of this machine that has ended; of another machine nobody knows."""
    host, process, began = [*theirs.split(), "", "", ""][:3]
    if host != socket.gethostname() or not process.isdecimal():
        return False
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        pass
    # A number is given again to another process.
    return _began(int(process)) != began


def _began(process: int) -> str:
    """When a process began, as Linux counts; a dash where it does not tell."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            return file.read().rpartition(b")")[2].split()[19].decode()
    except (OSError, IndexError):
        return "-"
