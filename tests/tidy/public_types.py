#!/usr/bin/env python3
"""Lists the public headers of SFT and the types that they add to namespace sft.

Usage: public_types.py [ROOT]

Public headers are those below the include folders of core and typesupport/runtime, except sft/detail. A type is a
class, struct, enumeration, alias or concept that is defined at the level of a namespace: sft or one within it, except
sft::detail. Classes within classes and forward declarations do not count. A public header that includes a header of the
project other than a public one or one of sft/detail is an error.
"""
import pathlib
import re
import sys

INCLUDE_FOLDERS = ("core/include", "typesupport/runtime/include")
COMMENTS_AND_TEXTS = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)
PROJECT_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
ALIAS_OR_CONCEPT = re.compile(r"\b(?:using|concept)\s+(\w+)\s*=")
DEFINITION = re.compile(r"\b(?:class|struct|enum(?:\s+(?:class|struct))?)\s+(?:\[\[.*?\]\]\s*)?(\w+)\b(?!\s*::)")


def public_headers(root):
    """All public headers as {path below its include folder: file}."""
    headers = {}
    for folder in INCLUDE_FOLDERS:
        for file in sorted((root / folder).rglob("*.h")):
            name = file.relative_to(root / folder).as_posix()
            if not name.startswith("sft/detail/"):
                headers[name] = file
    return dict(sorted(headers.items()))


def declared_type(head):
    """The name of the class, struct or enumeration that the text before a brace begins to define, or None."""
    head = re.sub(r"^\s*template\s*<", "<", head)
    depth = 0
    plain = ""
    for c in head:  # what stands between angle brackets declares parameters
        depth += (c == "<") - (c == ">")
        plain += c if depth == 0 else " "
    found = DEFINITION.search(plain)
    is_function = "(" in re.sub(r"\balignas\s*\([^)]*\)", "", plain)
    return found.group(1) if found and not is_function else None


def types_of(text):
    """The types of one header, in order."""
    text = COMMENTS_AND_TEXTS.sub('""', text)
    text = re.sub(r"^\s*#.*$", "", text, flags=re.MULTILINE)
    types = []
    scopes = []  # a list of names for a namespace, None for any other brace
    statement = ""
    for c in text:
        if c not in "{};":
            statement += c
            continue
        at_namespace = all(scope is not None for scope in scopes)
        names = [name for scope in scopes if scope for name in scope]
        is_public = at_namespace and names[:1] == ["sft"] and "detail" not in names
        if c == "{":
            namespace = re.search(r"\bnamespace\s+([\w:]*)\s*$", statement)
            if is_public and not namespace:
                name = declared_type(statement)
                types += [name] if name else []
                alias = ALIAS_OR_CONCEPT.search(statement)
                types += [alias.group(1)] if alias else []
            scopes.append(namespace.group(1).split("::") if namespace else None)
        elif c == "}":
            scopes.pop()
        elif is_public:
            alias = ALIAS_OR_CONCEPT.search(statement)
            types += [alias.group(1)] if alias else []
        statement = ""
    return types


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    headers = public_headers(root)
    total = 0
    errors = 0
    for name, file in headers.items():
        text = file.read_text(encoding="utf-8")
        types = types_of(text)
        total += len(types)
        print(f"{name}: {len(types)}: {', '.join(types)}")
        for included in PROJECT_INCLUDE.findall(text):
            if included not in headers and not included.startswith("sft/detail/"):
                print(f"error: {name} includes {included}, which is neither public nor in sft/detail")
                errors += 1
    print(f"{len(headers)} public headers, {total} public types")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
