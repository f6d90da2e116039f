"""A job that may take its process with it, in a module of its own: each new process imports no more than this."""

import os
import signal


def square_or_die(number: int) -> int:
    if number == 4:
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number
