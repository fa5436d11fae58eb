"""The files of a checkout, and their contents."""

import functools
import os
import subprocess

CODE = (".h", ".hpp", ".cpp", ".c")
SCRIPTS = (".cmake", ".py", ".lua", ".sh", ".bash", ".awk", "CMakeLists.txt", "/run")
NOT_OURS = ("build", ".git", "__pycache__")


class Tree:
    """The files that git tracks or would add. Without git, all files."""

    def __init__(self, root):
        self.root = os.path.abspath(root)
        self.files = sorted(path for path in self._listed() if os.path.isfile(self._full(path)))
        self.code = [path for path in self.files if path.endswith(CODE)]
        self.documents = [path for path in self.files if path.endswith(".md")]
        self.scripts = [path for path in self.files if ("/" + path).endswith(SCRIPTS)]

    @functools.lru_cache(maxsize=None)
    def text(self, path):
        with open(self._full(path), encoding="utf-8", errors="replace") as file:
            return file.read()

    def lines(self, path):
        return self.text(path).splitlines()

    def _full(self, path):
        return os.path.join(self.root, path)

    def _listed(self):
        if os.path.exists(self._full(".git")):
            command = ["git", "-C", self.root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
            git = subprocess.run(command, capture_output=True, text=True, check=False)
            if git.returncode == 0:
                return set(git.stdout.split("\0")) - {""}
        return self._walked()

    def _walked(self):
        found = set()
        for folder, folders, names in os.walk(self.root):
            folders[:] = [name for name in folders if name not in NOT_OURS]
            found.update(os.path.relpath(os.path.join(folder, name), self.root) for name in names)
        return found


def line_at(text, offset):
    return text.count("\n", 0, offset) + 1
