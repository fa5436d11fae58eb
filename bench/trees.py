"""The two sides of a comparison: this tree, and a commit in a worktree in build/against. Builds and runs benchmarks."""

import json
import os
import re
import subprocess
import tempfile

import processes


class Refusal(Exception):
    """Raised if the request of the user cannot be fulfilled."""


def git(root, *arguments):
    done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Refusal(f"git {' '.join(arguments)} fails: {done.stderr.strip()}")
    return done.stdout.strip()


def check_out(root, name):
    """Returns the tree of a commit. The tree is kept for later runs. If its folder was deleted, git keeps an entry."""
    try:
        commit = git(root, "rev-parse", "--verify", "--quiet", "--end-of-options", name + "^{commit}")
    except Refusal:
        raise Refusal(f"there is no commit '{name}' in this repository") from None
    folder = os.path.join(root, "build", "against")
    forget_deleted(root, folder)
    path = os.path.join(folder, commit)
    if not os.path.exists(path):
        git(root, "worktree", "add", "--detach", path, commit)
    elif not is_checkout(path, commit):
        raise Refusal(f"{path} is no unchanged checkout of {commit}; delete it, and it is made again")
    return Tree(path, git(root, "log", "-1", "--format=%h (%s)", commit))


def is_checkout(path, commit):
    return (os.path.realpath(git(path, "rev-parse", "--show-toplevel")) == os.path.realpath(path)
            and git(path, "rev-parse", "HEAD") == commit
            and not git(path, "status", "--porcelain", "--untracked-files=no"))


def forget_deleted(root, folder):
    """Removes the entries of worktrees whose folder in `folder` is gone from `git worktree list`."""
    for line in git(root, "worktree", "list", "--porcelain").splitlines():
        path = line.removeprefix("worktree ")
        if path != line and os.path.dirname(path) == os.path.realpath(folder) and not os.path.exists(path):
            git(root, "worktree", "remove", "--force", path)


class Tree:
    def __init__(self, root, title):
        self.root = root
        self.title = title

    def has(self, name):
        return os.path.isfile(os.path.join(self.root, "bench", name, "main.cpp"))

    def build(self, names):
        """Builds benchmarks, and returns the names of those that do not build."""
        # One build of all is faster than a build for each.
        if self._build([f"bench_{name}" for name in names]):
            return []
        if len(names) == 1:
            return names
        return [name for name in names if not self._build([f"bench_{name}"])]

    def _build(self, targets):
        # The output of a build goes to stderr, since it is no result.
        return processes.run([os.path.join(self.root, "run"), "build", *targets, "sftd"], stdout=2) == 0

    def program(self, name):
        return os.path.join(self.root, "build", "release", "bin", f"bench_{name}")

    def options(self, name):
        """Returns the options of a benchmark, each with the list of its values, or with None if it takes any value."""
        command = ["timeout", "60", self.program(name), "--help"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        found = re.findall(r"^\s+(?:-\w,)?(--[\w-]+)(?: \w+(?::\{([^}]*)\})?)?", done.stdout, re.MULTILINE)
        return {option: values.split(",") if values else None for option, values in found}

    def run(self, name, arguments, limit_s, out):
        """Runs a benchmark. Returns its figures, and what went wrong if there are none."""
        with tempfile.TemporaryDirectory(prefix="sft_bench_") as folder:
            file = os.path.join(folder, "figures.json")
            code = processes.run([self.program(name), "--json", file, *arguments], limit_s, cwd=self.root, stdout=out)
            if code is None:
                return None, f"does not end within {limit_s:g} s"
            if code != 0:
                return None, f"fails with exit code {code}"
            try:
                with open(file, encoding="utf-8") as figures:
                    return json.load(figures), ""
            except (OSError, ValueError) as error:
                return None, f"writes no figures: {error}"
