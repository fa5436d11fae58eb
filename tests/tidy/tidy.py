#!/usr/bin/env python3
"""Measures the order of a checkout, and checks that it holds.

tidy.py figures [--root DIR]            prints a table of figures; DIR may be another checkout, to compare with
tidy.py check [NAME...] [--root DIR]    prints what breaks the checks, with file and line; all checks without NAME
tidy.py list                            prints the names of the checks
tidy.py types [--root DIR]              prints the types that each public header gives to users
"""

import argparse
import gc
import os
import signal
import sys

sys.dont_write_bytecode = True  # writes no compiled files beside the sources
import checks
import figures
import headers
from settings import Settings
from tree import Tree

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def main():
    gc.disable()  # the collector would search millions of tokens, which stay until the end and form no cycles
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # the reader of the output may end early, as `head` does
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["figures", "check", "list", "types"])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--root", default=ROOT, metavar="DIR", help="the checkout (default: the one of this script)")
    arguments = parser.parse_args()
    unknown = set(arguments.names) - set(checks.ALL)
    if unknown:
        parser.error(f"no check is called {', '.join(sorted(unknown))}; there are: {', '.join(checks.ALL)}")
    if arguments.command == "list":
        print("\n".join(checks.ALL))
        return 0
    if not os.path.isdir(arguments.root):
        parser.error(f"{arguments.root} is no folder; --root takes the folder of a checkout")
    tree, settings = Tree(arguments.root), Settings(arguments.root)
    if arguments.command == "figures":
        print("\n".join(figures.table(tree, settings)))
        return 0
    if arguments.command == "types":
        print_types(tree, settings)
        return 0
    return check(arguments.names or checks.ALL, tree, settings)


def print_types(tree, settings):
    types = list(headers.public_types(tree, settings))
    for path in headers.public_headers(tree, settings):
        if not headers.is_detail(path):
            print(f"{path}: {', '.join(name for where, _, name in types if where == path)}")


def check(names, tree, settings):
    broken = False
    for name in names:
        findings = list(checks.ALL[name](tree, settings))
        for finding in findings:
            print(finding)
        if findings:
            print(f"{name}: {len(findings)} to mend", file=sys.stderr)
        broken = broken or bool(findings)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
