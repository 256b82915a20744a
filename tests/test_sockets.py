"""The audit of sockets in all tests (see `conftest`) detects connections."""

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

FAR = [
    'socket.create_connection(("192.0.2.1", 80))',
    'socket.create_server(("0.0.0.0", 0))',
    'socket.create_server(("", 0))',
    'socket.getaddrinfo("example.org", 80)',
    'socket.socket(type=socket.SOCK_DGRAM).sendto(b"x", ("192.0.2.1", 53))',
    'socket.create_server(("::", 0), family=socket.AF_INET6)',
]


@pytest.mark.parametrize("call", FAR)
def test_what_reaches_beyond_this_machine_is_refused_and_noted(call, tmp_path):
    environment = {**os.environ, "TAICHIFLAP_SOCKETS": str(tmp_path / "noted")}
    script = f"import socket\ntry: {call}\nexcept OSError: pass"
    subprocess.run([sys.executable, "-c", script], env=environment, check=True)
    assert "by ['-c']" in (tmp_path / "noted").read_text()


def test_what_stays_here_is_not():
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()):
        pass
    assert not Path(os.environ["TAICHIFLAP_SOCKETS"]).read_text()
