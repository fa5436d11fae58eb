"""Runs programs with a time limit, and ends all processes that they leave behind."""

import ctypes
import os
import signal
import subprocess
import time

NOWHERE = subprocess.DEVNULL
PR_SET_CHILD_SUBREAPER = 36
PATIENCE_S = 5  # time for a process to end after SIGTERM


def adopt_orphans():
    """Makes daemons that the programs start children of this process, so that end_all() finds them."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def run(command, limit_s=None, **options):
    """Returns the exit code, or None after the time limit. In all cases, none of the command's processes is left."""
    try:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True, **options)
        return process.wait(limit_s)
    except subprocess.TimeoutExpired:
        return None
    finally:
        end_all()  # also a process that an interrupted Popen() has started


def end_all():
    """Ends all processes that this one or its children have started. They have PATIENCE_S to clean up."""
    asked_until = time.monotonic() + PATIENCE_S
    asked = set()
    while left_after_reaping():
        patient = time.monotonic() < asked_until
        for pid in descendants(os.getpid()):
            if not patient or pid not in asked:
                send(pid, signal.SIGTERM if patient else signal.SIGKILL)
                asked.add(pid)
        time.sleep(0.01)


def send(pid, number):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


def left_after_reaping():
    """Reaps dead children. Returns true if children are left, including orphans that this process has adopted."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return False
    return True


def descendants(ancestor):
    children = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
                parent = int(stat.read().rpartition(")")[2].split()[1])
        except (OSError, IndexError):
            continue  # the process has ended meanwhile
        children.setdefault(parent, []).append(int(pid))
    found, next_ones = [], [ancestor]
    while next_ones:
        next_ones = [child for parent in next_ones for child in children.get(parent, [])]
        found += next_ones
    return found
