"""Rooms (folders), the arrows between them (includes), and knots (file pairs that include each other in a circle)."""

import os
import re
from collections import defaultdict
from typing import NamedTuple

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)
ALL_BELOW = "..."  # at the end of a room's name; the room then contains all folders below


class Include(NamedTuple):
    path: str    # the file that includes
    line: int
    quoted: bool
    name: str    # the path as written in the source
    target: str  # the included file if it belongs to the project, or ""


class Includes:
    def __init__(self, tree, settings):
        self._files = set(tree.files)
        self._public = settings.public_folders
        self._private = settings.private_folders
        self.all = [include for path in tree.code for include in self._of(path, tree.text(path))]

    def _of(self, path, text):
        for found in _INCLUDE.finditer(text):
            quoted, name = found[1] == '"', found[2]
            line = text.count("\n", 0, found.start(2)) + 1
            yield Include(path, line, quoted, name, self._target(path, name, quoted))

    def _target(self, path, name, quoted):
        folders = [*self._public, ""]
        if quoted:
            folders = [os.path.dirname(path), *folders, *self._private]
        for folder in folders:
            target = os.path.normpath(os.path.join(folder, name))
            if target in self._files:
                return target
        return ""


class Rooms:
    """The rooms of rooms.toml. A room may include itself, the rooms that it names, and all that these may include."""

    def __init__(self, table):
        self.table = table
        self._reach = {}

    def room_of(self, path):
        """Returns the room of a file, or "" if no room contains the file's folder."""
        folder = os.path.dirname(path)
        if folder in self.table:
            return folder
        while folder:
            deep = f"{folder}/{ALL_BELOW}"
            if deep in self.table:
                return deep
            folder = os.path.dirname(folder)
        return ""

    def may_include(self, room):
        if room not in self._reach:
            self._reach[room] = {room}  # set before the recursion, because rooms.toml may have a circle by mistake
            for other in self.table[room]["includes"]:
                self._reach[room] |= self.may_include(other) if other in self.table else set()
        return self._reach[room]

    def errors(self):
        """Yields the errors of the table. A room may only name rooms before it, so that there are no circles."""
        seen = set()
        for room, line in self.table.items():
            for other in line["includes"]:
                if other not in self.table:
                    yield f"room {room} names {other}, which is no room: correct the name"
                elif other not in seen:
                    yield f"room {room} names {other}, which stands below it: put {other} first"
            seen.add(room)


def arrows(includes, room_of):
    """Returns the includes between rooms: {(from, to): [includes]}."""
    found = defaultdict(list)
    for include in includes.all:
        if include.target and room_of(include.path) != room_of(include.target):
            found[room_of(include.path), room_of(include.target)].append(include)
    return found


def upward(includes, rooms):
    """Yields the includes that rooms.toml does not allow."""
    for (source, target), found in arrows(includes, rooms.room_of).items():
        if source and target and target not in rooms.may_include(source):
            yield from found


def pair_of(path):
    """Returns the name of a pair X.h and X.cpp. Files of one name in different folders are different pairs."""
    return os.path.splitext(path)[0]


def knots(includes):
    """Returns the groups of file pairs that include each other in a circle (Tarjan's strongly connected components)."""
    graph = defaultdict(set)
    for include in includes.all:
        source, target = pair_of(include.path), pair_of(include.target)
        if target and source != target:
            graph[source].add(target)
            graph[target] |= set()
    return sorted(sorted(group) for group in _components(graph) if len(group) > 1)


def _components(graph):
    number, low, stack, on_stack, found = {}, {}, [], set(), []

    def visit(node):
        number[node] = low[node] = len(number)
        stack.append(node)
        on_stack.add(node)
        for other in graph[node]:
            if other not in number:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on_stack:
                low[node] = min(low[node], number[other])
        if low[node] == number[node]:
            group = set()
            while node not in group:
                group.add(stack.pop())
            on_stack.difference_update(group)
            found.append(group)

    for node in list(graph):
        if node not in number:
            visit(node)
    return found
