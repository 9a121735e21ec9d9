"""Ports of this computer, for servers that tests start."""
import socket

from awaiting import await_true


def free_port():
    """One that no server has now."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


def await_listening(port, what, address="127.0.0.1"):
    """Until `what` accepts connections there."""
    def listens():
        try:
            socket.create_connection((address, port)).close()
            return True
        except OSError:
            return False
    await_true(listens, what)
