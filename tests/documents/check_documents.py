#!/usr/bin/env python3
"""check_documents.py ROOT: checks the documents, and prints faults by file and line.

- Each link to a file or a heading has a target.
- README.md has at most 150 lines and fewer than 1,000 words.
- Each number below "Four figures" in README.md is in docs/performance.md, and the sentence below the picture is in
  README.md.
- Each constant or option that docs/limits.md names is in the sources.
- ARCHITECTURE.md and the documents beside the code name files, tests, classes and constants that exist.
"""

import pathlib
import re
import sys

FOR_USERS = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "docs/*.md")
BESIDE_CODE = ("ARCHITECTURE.md", "core/*/*.md", "udp_transport/*/*.md", "shm_transport/*/*.md", "tests/*/*.md",
               "typesupport/*/*.md")
SOURCES = ("core", "shm_transport", "udp_transport", "typesupport", "cmake", "CMakeLists.txt")
SOURCE_KINDS = {".h", ".cpp", ".toml", ".idl", ".txt"}
README_LINES_MAX, README_WORDS_MAX = 150, 999

LINK = re.compile(r"\]\(([^)\s]+)\)|(?:src|srcset)=\"([^\"]+)\"")
NUMBER = re.compile(r"\d[\d,.]*\d|\d")
CODE = re.compile(r"`([^`]+)`")
FILE = re.compile(r"\b\w+\.(?:h|cpp|md|pml|lua|cmake|awk|py|toml)\b")
TEST = re.compile(r"(?:^|[\s/])([A-Z]\w+)\.([A-Z]\w*)(\*?)$")
TESTS_OF_SOURCES = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+),\s*(\w+)", re.MULTILINE)
IDENTIFIER = re.compile(r"^[A-Za-z_]\w*(?:::[A-Za-z_]\w*)+(?:\(\))?$")
NAME = re.compile(r"`([A-Za-z_][A-Za-z0-9_:.]*)`")


def without_code(text):
    """Yields the lines of a document, with empty ones in place of code blocks."""
    in_code = False
    for line in text.splitlines():
        fence = line.startswith("```")
        in_code ^= fence
        yield "" if fence or in_code else line


def anchors(file):
    """Returns the anchors of the headings of a document, as GitHub makes them."""
    headings = (line.lstrip("#").strip() for line in without_code(file.read_text()) if line.startswith("#"))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def check_links(root, file):
    for number, line in enumerate(without_code(file.read_text()), 1):
        for match in LINK.finditer(line):
            target, _, anchor = (match[1] or match[2]).partition("#")
            if ":" in target:
                continue
            there = (file.parent / target).resolve() if target else file
            if not there.exists():
                yield f"{file.relative_to(root)}:{number}: there is no {target}"
            elif anchor and anchor not in anchors(there):
                yield f"{file.relative_to(root)}:{number}: {there.relative_to(root)} has no heading for #{anchor}"


def check_size(root):
    text = (root / "README.md").read_text()
    for count, most, what in ((len(text.splitlines()), README_LINES_MAX, "lines"),
                              (len(text.split()), README_WORDS_MAX, "words")):
        if count > most:
            yield f"README.md: {count} {what}; it may have {most}: move something to docs/"


def section(text, heading):
    return text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]


def check_figures(root):
    readme = (root / "README.md").read_text()
    measured = set(NUMBER.findall((root / "docs/performance.md").read_text()))
    for number in NUMBER.findall(section(readme, "Four figures")):
        if number not in measured:
            yield f"README.md: {number}, below 'Four figures', is not in docs/performance.md"
    sentence = re.search(r"The network carried [^<]+", (root / "docs/picture/light.svg").read_text())[0]
    if sentence not in readme:
        yield f"README.md: the picture says '{sentence}', and README.md does not"


def words_of_sources(root, *more):
    words = set()
    for top in (root / name for name in SOURCES + more):
        for file in [top] if top.is_file() else top.rglob("*"):
            if file.suffix in SOURCE_KINDS:
                words.update(re.findall(r"[A-Za-z_]\w*", file.read_text(errors="replace")))
    return words


def check_limits(root):
    """Checks the names in the last column of each table. They name the code that enforces the limit."""
    known = words_of_sources(root)
    for number, line in enumerate(without_code((root / "docs/limits.md").read_text()), 1):
        cells = line.strip("|").split("|")
        if not line.startswith("|") or len(cells) < 3:
            continue
        for name in NAME.findall(cells[-1]):
            for word in re.split(r"::|\.", name):
                if word not in known:
                    yield f"docs/limits.md:{number}: '{word}' of `{name}` is not in the sources: was it renamed?"


def tests_of_sources(root):
    for file in (root / "tests").rglob("*.cpp"):
        for match in TESTS_OF_SOURCES.finditer(file.read_text(errors="replace")):
            yield match[1], match[2]


def check_names(root, file, files, tests, words):
    """Checks a text that a document has as `code`, if the text looks like a file, a test, or a member of a class."""
    where = file.relative_to(root)
    for number, line in enumerate(without_code(file.read_text()), 1):
        for code in CODE.findall(line):
            for name in FILE.findall(code):
                if name not in files:
                    yield f"{where}:{number}: there is no file {name}"
            test = TEST.search(code)
            matches = [] if not test else [
                name for suite, name in tests
                if suite == test[1] and (name == test[2] or test[3] and name.startswith(test[2]))]
            if test and not matches:
                yield f"{where}:{number}: there is no test {code}"
            if IDENTIFIER.match(code):
                for word in re.split(r"::", code.removesuffix("()")):
                    if word not in words:
                        yield f"{where}:{number}: '{word}' of `{code}` is not in the sources: was it renamed?"


def main(root):
    wrong = [*check_size(root), *check_figures(root), *check_limits(root)]
    for pattern in FOR_USERS + BESIDE_CODE:
        documents = sorted(root.glob(pattern))
        wrong += [] if documents else [f"there is no {pattern}"]
        for document in documents:
            wrong += check_links(root, document)
    folders = ("core", "shm_transport", "sft", "tests", "tools", "typesupport", "udp_transport")
    files = {file.name for folder in folders for file in (root / folder).rglob("*")}
    files.update(file.name for file in root.glob("*.md"))
    tests = set(tests_of_sources(root))
    words = words_of_sources(root, "tests", "tools")
    for document in (file for pattern in BESIDE_CODE for file in sorted(root.glob(pattern))):
        wrong += check_names(root, document, files, tests, words)
    print("\n".join(wrong) or "All links and names lead somewhere, and all figures and limits are in their places.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
