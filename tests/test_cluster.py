"""Sweeps on Dask: a real scheduler and two worker processes, one of which dies during the sweep."""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest
import xarray
from conftest import CASES, done, hawkmoth

import taichiflap
from taichiflap.errors import UserError

pytestmark = pytest.mark.slow

VARY = {"wing.youngs_modulus": "1e10:4e10:12"}
STUDY = """
import taichiflap
from taichiflap.studies import batch, sweep
batch.BATCH_BYTES, sweep.WRITTEN_EVERY = 1, 0.0  # a batch a case, written at once

if __name__ == "__main__":
    case = taichiflap.load_case({case!r}, ["time.periods=3", "uvlm.panels=20"])
    taichiflap.sweep(case, {vary!r}, "map.h5", cluster={address!r})
"""


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two workers, each a process; yields its address and the workers."""
    environment = {**os.environ, "DASK_DISTRIBUTED__ADMIN__LOG_FORMAT": "%(message)s"}
    quiet = {"cwd": tmp_path, "env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    address_file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_{}"]
    common = ["--scheduler-file", str(address_file)]
    # Dask's own programs listen everywhere unless told not to, with --no-dashboard too.
    common += ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]
    processes = [subprocess.Popen([*dask[:2], dask[2].format("scheduler"), *common, "--port", "0"], **quiet)]
    while not address_file.exists() or not address_file.stat().st_size:
        time.sleep(0.1)
    worker = [*dask[:2], dask[2].format("worker"), *common, "--nthreads", "1", "--no-nanny"]
    processes += [subprocess.Popen(worker, **quiet) for _ in range(2)]
    yield json.loads(address_file.read_text())["address"], processes[1:]
    for process in processes[::-1]:
        process.kill()
        process.wait()


def test_a_cluster_gives_the_bits_of_this_process_and_outlives_a_worker(cluster, tmp_path):
    address, workers = cluster
    case = hawkmoth("time.periods=3", "uvlm.panels=20")
    (tmp_path / "study.py").write_text(STUDY.format(case=str(CASES / "hawkmoth.toml"), vary=VARY, address=address))
    with subprocess.Popen([sys.executable, "study.py"], cwd=tmp_path, stderr=subprocess.PIPE, text=True) as study:
        until = time.monotonic() + 120
        streamed = set()
        while study.poll() is None and time.monotonic() < until:
            streamed.add(done(tmp_path / "map.h5"))
            if 0 < max(streamed) < 9 and workers[0].poll() is None:
                workers[0].send_signal(signal.SIGKILL)
            time.sleep(0.02)
        said = study.communicate(timeout=5)[1]
    assert study.returncode == 0, said
    assert workers[0].poll() == -signal.SIGKILL
    assert len(streamed) > 3  # results came one by one
    with xarray.open_dataset(tmp_path / "map.h5") as remote:
        here = taichiflap.sweep(case, VARY)
        assert (remote.status == 1).all()
        xarray.testing.assert_equal(remote.load().drop_vars("reason"), here.drop_vars("reason"))


@pytest.mark.parametrize(
    ("address", "sentence"),
    [
        ("tcp://127.0.0.1:9", "no Dask scheduler answers there, after "),
        ("carrier-pigeon://coop", "no Dask scheduler answers there, after "),
        ("local:none", "write local:N"),
        ("local:0", "write local:N"),
    ],
)
def test_an_address_that_nobody_answers_is_a_sentence_and_harms_nothing(address, sentence, tmp_path, monkeypatch):
    monkeypatch.setattr("taichiflap.studies.cluster.PATIENCE", 1)
    with pytest.raises(UserError) as refused:
        taichiflap.sweep(hawkmoth("solver=dbet"), {"wing.modes": "0,1"}, tmp_path / "map.h5", cluster=address)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)
    assert done(tmp_path / "map.h5") == 0


def speak(listening, words):
    """Answer every connection with some text."""
    with contextlib.ExitStack() as callers, contextlib.suppress(OSError):
        while True:
            caller = callers.enter_context(listening.accept()[0])
            with contextlib.suppress(OSError):
                caller.sendall(words)
            if words:
                caller.close()


@pytest.mark.parametrize("words", [b"", b"HTTP/1.0 400 Bad Request\r\n\r\n", b"\xff" * 64, bytes(64)])
def test_another_server_at_the_address_is_a_sentence(words, tmp_path, monkeypatch):
    monkeypatch.setattr("taichiflap.studies.cluster.PATIENCE", 1)
    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=speak, args=(listening, words), daemon=True).start()
        address = f"tcp://127.0.0.1:{listening.getsockname()[1]}"
        with pytest.raises(UserError, match=r"no Dask scheduler answers there, after \d+ s") as refused:
            taichiflap.sweep(hawkmoth("solver=dbet"), {"wing.modes": "0,1"}, tmp_path / "map.h5", cluster=address)
        listening.shutdown(socket.SHUT_RDWR)
    assert "\n" not in str(refused.value)


def test_a_scheduler_without_workers_is_a_sentence(cluster, tmp_path, monkeypatch, capsys):
    address, workers = cluster
    for worker in workers:
        worker.kill()
        worker.wait()
    time.sleep(1.0)  # until the scheduler has noticed
    monkeypatch.setattr("taichiflap.studies.cluster.PATIENCE", 3)
    monkeypatch.setattr("taichiflap.studies.cluster.WORKERS_PATIENCE", 1)
    with pytest.raises(UserError, match=r"the scheduler has no workers, after 4 s; start one with: dask worker tcp:"):
        taichiflap.sweep(hawkmoth("solver=dbet"), {"wing.modes": "0,1"}, tmp_path / "map.h5", cluster=address)
    assert "no workers yet; waiting for 1 s more" in capsys.readouterr().err


@pytest.fixture
def dashboard_taken():
    """The port that a scheduler's dashboard asks for first, held by another."""
    with socket.socket() as taken:
        with contextlib.suppress(OSError):  # held already
            taken.bind(("127.0.0.1", 8787))
            taken.listen()
        yield


@pytest.mark.usefixtures("dashboard_taken")
def test_workers_started_here(tmp_path):
    command = [sys.executable, "-m", "taichiflap", "sweep", str(CASES / "hawkmoth_dbet.toml"), "--set=time.periods=1"]
    command += ["--vary", "wing.youngs_modulus=1e10:2e10:8", "-o", "map.h5", "--cluster", "local:1"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=200)
    assert ran.returncode == 0
    # On a busy machine it tells now and then how far it is.
    assert [line for line in ran.stderr.splitlines() if "of 8 cases" not in line] == []
    assert "8 complete, 0 failed" in ran.stdout


def test_without_dask_the_extra_is_named(tmp_path):
    (tmp_path / "distributed.py").write_text("raise ImportError")
    command = [sys.executable, "-m", "taichiflap", "sweep", str(CASES / "hawkmoth_dbet.toml")]
    command += ["--vary", "wing.modes=0,1", "-o", "map.h5", "--cluster", "local:2"]
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}:{CASES.parent}"}
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ran.returncode, 'pip install "taichiflap[cluster]"' in ran.stderr) == (2, True)


STANDING_IN = {
    "python": f'exec {sys.executable} "$@"',
    "dask": f'exec {sys.executable} -m dask "$@" --host 127.0.0.1 --dashboard-address 127.0.0.1:0',
    "taichiflap": f'exec {sys.executable} -m taichiflap "$@"',
    "srun": 'shift 3; exec "$@"',  # -n 1 --overlap
    "sbatch": 'bash "$1" & echo Submitted batch job $!',
    "scancel": 'kill "$@"',
}
"""What the documentation's scripts call, on one machine."""

NEAR = {
    "DASK_JOBQUEUE__SLURM__SCHEDULER_OPTIONS": "{'host': '127.0.0.1', 'dashboard_address': '127.0.0.1:0'}",
    "DASK_JOBQUEUE__SLURM__WORKER_EXTRA_ARGS": "['--host', '127.0.0.1', '--dashboard-address', '127.0.0.1:0']",
}
"""What keeps `dask-jobqueue` there."""


@pytest.mark.parametrize("number", [1, 2], ids=["allocation", "jobs"])
def test_the_documented_scripts_for_slurm_run(number, tmp_path):
    blocks = re.findall(r"```(bash|python)\n(.*?)```", (CASES.parent / "docs" / "cluster.md").read_text(), re.DOTALL)
    language, script = blocks[number]
    for placeholder, value in {
        "CASE": str(CASES / "hawkmoth_dbet.toml"),
        "--vary ...": "--vary wing.youngs_modulus=1e10:2e10:3 --set=time.periods=2",
        "srun -n 255": "srun -n 1",
        "scale(256)": "scale(1)",
        "5e9:60e9:40:log": "5e9:60e9:3:log",
        "5:45:41": "5:45:2",
    }.items():
        script = script.replace(placeholder, value)
    (tmp_path / "bin").mkdir()
    for name, line in STANDING_IN.items():
        (tmp_path / "bin" / name).write_text(f"#!/bin/bash\n{line}\n")
        (tmp_path / "bin" / name).chmod(0o755)
    (tmp_path / "script").write_text(script)
    environment = {**os.environ, **NEAR, "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}"}
    options = {"cwd": tmp_path, "env": environment, "stderr": subprocess.STDOUT, "start_new_session": True}
    with open(tmp_path / "said", "w") as said:
        study = subprocess.Popen([language, "script"], stdout=said, **options)
    try:
        assert study.wait(120) == 0, (tmp_path / "said").read_text()
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(study.pid, signal.SIGKILL)  # scheduler and worker, which SLURM would end with the job
    assert done(tmp_path / "map.h5") == {1: 3, 2: 6}[number]
