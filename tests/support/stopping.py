"""One thread of a program stands still, by the program stop-thread, in tests in Python."""
import os
import subprocess


class StoppedThread:
    """The thread `name` of a process stands still from here on, until the end. Raises PermissionError where threads may not be stopped."""

    def __init__(self, process_id, name):
        program = os.path.join(os.environ["SLIPD_BINARY_DIR"], "test-bin", "stop-thread")
        self._holder = subprocess.Popen([program, str(process_id), name], stdout=subprocess.PIPE, text=True)
        if self._holder.stdout.readline() != "stopped\n":
            self.end()
            raise PermissionError(f"the thread {name} of {process_id} may not be stopped here: root may")

    def end(self):
        """It goes on."""
        self._holder.kill()
        self._holder.wait()
        self._holder.stdout.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
