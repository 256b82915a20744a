"""Safe renaming and locking of files: files are synced before they are renamed, and locked by a lock file.

HDF5's own lock is often disabled on NFS and Lustre. `NAME.lock` contains the host and process that writes NAME; the
lock of a dead process is taken over.
"""

import contextlib
import os
import socket
from pathlib import Path

SUFFIX = ".lock"
LONGEST_NAME = 224
"""Maximum length of a file name in bytes; drafts and locks have longer names, and systems allow 255."""


class Busy(Exception):
    """Raised if another process is writing the file; names the process, and the cure if it is dead."""


def trouble(path: Path) -> str:
    """Why a file cannot be written, found before anything is computed; empty if it can."""
    if len(os.fsencode(path.name)) > LONGEST_NAME:
        return f"the name has {len(os.fsencode(path.name))} bytes; give one with at most {LONGEST_NAME}"
    try:
        path.stat()
    except FileNotFoundError:
        return "is a broken link; remove it, or name another file" if path.is_symlink() else ""
    except NotADirectoryError:
        return ""  # reported for its folder
    except OSError as error:
        return f"cannot be written: {error.strerror}"
    return ""


def sync(path: Path) -> None:
    """Make the system write a file to the disk.

    Raises:
        OSError: if it cannot be written.
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def replace(source: Path, target: Path) -> None:
    """Sync and rename a file; replacing another is optional.

    Raises:
        OSError: when the system refuses.
    """
    sync(source)
    os.replace(source, target)


class Lock:
    """Lock for writing a file, until `release`.

    Raises:
        Busy: if another process holds it.
        OSError: if the lock file cannot be created.
    """

    def __init__(self, path: Path) -> None:
        self.path = path.with_name(path.name + SUFFIX)
        self._ours = _sign()
        for _ in range(3):
            if self._create():
                return
            theirs = self._read()
            if theirs is None:
                continue  # released meanwhile
            if not _gone(theirs):
                host, process, *_ = [*theirs.split(), "?", "?"]
                raise Busy(f"process {process} on {host}; if it no longer runs, remove {self.path}")
            self._take_away(theirs)
        raise Busy(f"see {self.path}")

    def release(self) -> None:
        """Release the lock; may be called twice."""
        with contextlib.suppress(OSError):
            if self._read() == self._ours:
                self.path.unlink()

    def _create(self) -> bool:
        """Create the lock file atomically; returns whether we were the first."""
        draft = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            draft.write_text(self._ours)
            try:
                os.link(draft, self.path)
            except FileExistsError:
                return False
            except OSError:  # the file system has no links
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
        """Remove the lock of a dead process, unless another process has just done so."""
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
    """Whether a lock belongs to an ended process of this machine; unknown for other machines."""
    host, process, began = [*theirs.split(), "", "", ""][:3]
    if host != socket.gethostname() or not process.isdecimal():
        return False
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        pass
    # Process numbers are reused.
    return _began(int(process)) != began


def _began(process: int) -> str:
    """Start time of a process in Linux's counting; a dash if unknown."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            return file.read().rpartition(b")")[2].split()[19].decode()
    except (OSError, IndexError):
        return "-"
