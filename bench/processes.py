"""Runs programs that end in time, and leave no process behind."""

import ctypes
import os
import signal
import subprocess
import time

NOWHERE = subprocess.DEVNULL
PR_SET_CHILD_SUBREAPER = 36
PATIENCE_S = 5  # of those that are asked to end


def adopt_orphans():
    """Makes daemons of the programs children of this process, so that end_all() finds them."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def run(command, limit_s=None, **options):
    """The exit code, or None after the time limit. Whatever happens, none of the command's processes is left."""
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, **options)
    try:
        return process.wait(limit_s)
    except subprocess.TimeoutExpired:
        return None
    finally:
        end_all(process)


def end_all(process):
    if process.poll() is None:
        # A terminated build tool ends its compilers, which have process groups of their own.
        os.killpg(process.pid, signal.SIGTERM)
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            pass
    until = time.monotonic() + PATIENCE_S
    while (left := descendants(os.getpid())) and time.monotonic() < until:
        for pid in left:
            kill(pid)
        if process.poll() is not None:
            reap()
        time.sleep(0.01)


def kill(pid):
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def reap():
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass


def descendants(ancestor):
    children = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
                parent = int(stat.read().rpartition(")")[2].split()[1])
        except (OSError, IndexError):
            continue  # it has ended meanwhile
        children.setdefault(parent, []).append(int(pid))
    found, next_ones = [], [ancestor]
    while next_ones:
        next_ones = [child for parent in next_ones for child in children.get(parent, [])]
        found += next_ones
    return found
