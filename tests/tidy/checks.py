"""The checks of the tree. Each check yields the places that break its rule, and the change that mends them."""

import os
import re
from typing import NamedTuple

import comments
import headers
import lexer
import rooms
import structure
from tree import line_at

MID_SENTENCE_PERCENT_MAX = 5
_PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_ONE_WORD = re.compile(r"///< [a-z]+$")
_TOOLS_OF_THE_LANGUAGE = re.compile(r"[a-z_0-9]+|(?:stdint|stddef|string|stdlib|stdio|stdbool|limits|inttypes)\.h")


class Finding(NamedTuple):
    path: str
    line: int
    message: str

    def __str__(self):
        return f"{self.path}:{self.line}: {self.message}"


def includes_go_only_downward(tree, settings):
    plan = rooms.Rooms(settings.rooms)
    for error in plan.errors():
        yield Finding(settings.file, 1, error)
    for path in tree.code:
        if not plan.room_of(path):
            yield Finding(path, 1, f"folder {os.path.dirname(path)} is no room: give it a line in {settings.file}, "
                                   "or move the file")
    for include in sorted(rooms.upward(rooms.Includes(tree, settings), plan)):
        source, target = plan.room_of(include.path), plan.room_of(include.target)
        yield Finding(include.path, include.line,
                      f"{source} may not include {target} ({include.name}): move what it needs to a room below "
                      "both, or pass it in")


def rooms_exist(tree, settings):
    plan = rooms.Rooms(settings.rooms)
    used = {plan.room_of(path) for path in tree.code}
    for room in settings.rooms:
        if room not in used:
            yield Finding(settings.file, 1, f"room {room} has no source file: remove its line")


def no_knots(tree, settings):
    includes = rooms.Includes(tree, settings)
    for knot in rooms.knots(includes):
        lines = [f"{i.path}:{i.line}: {i.name}" for i in includes.all
                 if i.target and rooms.pair_of(i.path) in knot and rooms.pair_of(i.target) in knot
                 and rooms.pair_of(i.path) != rooms.pair_of(i.target)]
        yield Finding(knot[0], 1, f"{len(knot)} file pairs include each other in a circle: {', '.join(knot)}. Move "
                                  "what both sides need to a file of its own:\n    " + "\n    ".join(lines))


def sizes_are_within_limits(tree, settings):
    limits = settings.limits
    for path in tree.code:
        reasons = _Reasons(tree.lines(path))
        lines = len(tree.lines(path))
        if lines > limits["file_lines"] and not reasons.of_file():
            yield Finding(path, 1, f"the file has {lines} lines, more than {limits['file_lines']}: divide it")
        found = structure.read(tree.text(path))
        if not found.balanced:
            yield Finding(path, 1, "braces do not match: branches of #if and #else that open one each confuse readers "
                                   "and this check; let each branch be whole")
        for function in found.functions:
            if function.lines > limits["function_lines"] and not reasons.above(function.line):
                yield Finding(path, function.line, f"function {function.name} has {function.lines} lines, more than "
                                                   f"{limits['function_lines']}: divide it")
        for made in found.classes:
            if (made.data > limits["data_members"] or made.methods > limits["methods"]) and \
                    not reasons.above(made.line):
                yield Finding(path, made.line,
                              f"class {made.name} has {made.data} data members (limit {limits['data_members']}) and "
                              f"{made.methods} methods (limit {limits['methods']}): divide it")
        for line in reasons.unneeded():
            yield Finding(path, line, "nothing below this reason is larger than the limit any more: remove the line")


class _Reasons:
    """The lines of a file that give a reason why the following code may exceed the limits."""

    _BEGINNING = re.compile(r"\s*//+ Larger than usual: \S")

    def __init__(self, lines):
        self._lines = lines
        self._unused = {number for number, line in enumerate(lines, 1) if self._BEGINNING.match(line)}

    def above(self, line):
        """Returns true if the comment that ends above this line has a reason. Marks that reason as needed."""
        first = line - 1
        while first > 0 and self._lines[first - 1].lstrip().startswith("//"):
            first -= 1
        return self._take(range(first + 1, line))

    def of_file(self):
        end = next((number for number, line in enumerate(self._lines, 1) if not line.startswith("//")), 1)
        return self._take(range(1, end))

    def unneeded(self):
        return sorted(self._unused)

    def _take(self, numbers):
        found = {number for number in numbers if self._BEGINNING.match(self._lines[number - 1])}
        self._unused -= found
        return bool(found)


def libraries_stay_in_their_folders(tree, settings):
    for include in rooms.Includes(tree, settings).all:
        for library, folders in settings.libraries.items():
            if not include.target and include.name.startswith(library) and not _excused(include.path, folders):
                yield Finding(include.path, include.line,
                              f"only {', '.join(folders)} may include {include.name}: hide what it is for behind an "
                              "interface there")


def sources_are_in_cmake_lists(tree, settings):
    listed = [pattern for path in tree.scripts if path.endswith(("CMakeLists.txt", ".cmake"))
              for pattern in _sources_in(tree.text(path), os.path.dirname(path))]
    patterns = re.compile("|".join(listed) or "(?!)")
    for path in tree.code:
        if path.endswith((".c", ".cpp")) and not _excused(path, settings.unlisted) and not patterns.fullmatch(path):
            yield Finding(path, 1, "no CMakeLists.txt names this source file: add it to its target, or remove the file")


def _sources_in(text, folder):
    """Yields patterns of the paths in a list: relative to the list's folder, behind a variable, or by file(GLOB)."""
    text = re.sub(r"#.*", "", text)
    for name in re.findall(r"[^\s\"();]+\.(?:cpp|c)\b", text):
        name = name.removeprefix("${CMAKE_CURRENT_SOURCE_DIR}/")
        if name.startswith("${PROJECT_SOURCE_DIR}/"):
            yield re.escape(name.removeprefix("${PROJECT_SOURCE_DIR}/"))
        elif re.match(r"\$\{\w+\}/", name):
            yield r"(?:.*/)?" + re.escape(name.split("/", 1)[1])
        elif "$" not in name:
            yield re.escape(os.path.normpath(os.path.join(folder, name))).replace(r"\*", "[^/]*")


def _excused(path, table):
    return any(path.startswith(folder + "/") for folder in table)


def lines_fit_their_columns(tree, settings):
    for path in tree.files:
        limit = _columns(path, settings.columns)
        for number, line in enumerate(tree.lines(path) if limit else [], 1):
            if len(line) > limit and not _cannot_be_broken(line):
                yield Finding(path, number, f"{len(line)} columns, more than {limit}: break the line")


def _columns(path, columns):
    name = os.path.basename(path)
    return columns.get(name, columns.get(os.path.splitext(name)[1], 0))


def _cannot_be_broken(line):
    """Returns true if a line must not be broken: a row of a Markdown table, an address, or an include."""
    return line.lstrip().startswith(("|", "#include")) or re.fullmatch(r"\s*\S*https?://\S*", line)


def public_headers_include_public_ones(tree, settings):
    public = set(headers.public_headers(tree, settings))
    for include in rooms.Includes(tree, settings).all:
        if include.path not in public or include.target in public:
            continue
        if include.target or include.quoted:
            yield Finding(include.path, include.line,
                          f"a public header may not include {include.name}, which is not installed: make that public, "
                          "or include it in the .cpp file only")
        elif include.name not in settings.public_libraries and \
                not _TOOLS_OF_THE_LANGUAGE.fullmatch(include.name):
            yield Finding(include.path, include.line,
                          f"users need {include.name} for this public header: hide it in the .cpp file, or declare it "
                          f"in {settings.file}")


def public_types_are_few(tree, settings):
    """Limits the number of public types, so that readers of the reference find the important ones."""
    types, limit = len(list(headers.public_types(tree, settings))), settings.limits["public_types"]
    if types > limit:
        yield Finding(settings.file, 1, f"the public headers give users {types} types, more than {limit} (./run tidy "
                                        "types): nest a type that is only met as a part of another one in that one")


def words_are_plain(tree, settings):
    if not settings.words:
        return
    pattern = re.compile("|".join(rf"\b{re.escape(word)}\b" for word in settings.words), re.IGNORECASE)
    for path in [*tree.code, *tree.documents, *tree.scripts]:
        for found in pattern.finditer(tree.text(path)):
            better = settings.words[found[0].lower()]
            yield Finding(path, line_at(tree.text(path), found.start()), f'"{found[0]}" is hard to read: {better}')


def comments_begin_with_their_subject(tree, settings):
    """Lets MID_SENTENCE_PERCENT_MAX % of the blocks seem to begin in mid-sentence: the heuristic may be wrong."""
    all_blocks, found = 0, []
    for path, block, is_fragment in comment_blocks(tree, settings):
        all_blocks += 1
        if is_fragment:
            start = " ".join(block.text.split()[:6])
            found.append(Finding(path, block.line, f'"{start} ...": write a whole sentence that names its subject'))
    if len(found) * 100 >= all_blocks * MID_SENTENCE_PERCENT_MAX:
        yield from found


def comment_blocks(tree, settings):
    for path in tree.code:
        own_name = os.path.splitext(os.path.basename(path))[0]  # the comment of a program may begin with its name
        names = comments.names_in(tree.text(path)) | settings.names | {own_name}
        for block in comments.blocks(tree.text(path)):
            yield path, block, comments.begins_in_mid_sentence(block, names)


def identifiers_are_words_of_the_trade(tree, settings):
    """Accepts names in capitals (macros, definitions). Names of tests are sentences, and may have all words that other
    text may have."""
    for path in tree.code:
        for token in lexer.read(tree.text(path)).tokens:
            parts = _PARTS.findall(token.text) if token.kind == "word" else []
            if token.text.isupper():
                continue
            is_sentence = token.text[0].isupper() and len(parts) >= 4
            refused = settings.words if is_sentence else settings.metaphors
            for part in parts:
                better = refused.get(part.lower())
                if better:
                    yield Finding(path, token.line, f'{token.text}: "{part.lower()}" hides what is meant: {better}')


def trailing_comments_have_a_noun(tree, settings):
    for path in tree.code:
        for number, line in enumerate(tree.lines(path), 1):
            found = _ONE_WORD.search(line)
            goes_on = found and not line[:found.start()].strip()
            if found and not goes_on:
                yield Finding(path, number, f'"{found[0]}" is a fragment: write what the member is, with its noun')


def includes_have_one_style(tree, settings):
    """Paths are relative to the root of the project, in double quotes; public headers are "sft/..." or <sft/...>."""
    top_folders = {path.split("/")[0] for path in tree.code}
    for include in rooms.Includes(tree, settings).all:
        if include.quoted and not include.target and include.name.split("/")[0] in top_folders:
            yield Finding(include.path, include.line, f'there is no "{include.name}": correct the path')
        if not include.target or _excused(include.path, settings.private_folders):
            continue
        right = _without_folder(include.target, settings.public_folders)
        is_public = right != include.target
        private = _without_folder(include.target, settings.private_folders)
        if include.name != right and (include.name != private or private == include.target):
            yield Finding(include.path, include.line, f'write "{right}" instead of "{include.name}"')
        elif not include.quoted and not is_public:
            yield Finding(include.path, include.line, f'write "{right}" instead of <{right}>')


def _without_folder(path, folders):
    return next((path.removeprefix(folder + "/") for folder in folders if path.startswith(folder + "/")), path)


ALL = {
    "includes-go-only-downward": includes_go_only_downward,
    "libraries-stay-in-their-folders": libraries_stay_in_their_folders,
    "rooms-exist": rooms_exist,
    "file-pairs-form-no-knots": no_knots,
    "sizes-are-within-limits": sizes_are_within_limits,
    "sources-are-in-cmake-lists": sources_are_in_cmake_lists,
    "lines-fit-their-columns": lines_fit_their_columns,
    "public-headers-include-public-ones": public_headers_include_public_ones,
    "public-types-are-few": public_types_are_few,
    "words-are-plain": words_are_plain,
    "comments-begin-with-their-subject": comments_begin_with_their_subject,
    "identifiers-are-words-of-the-trade": identifiers_are_words_of_the_trade,
    "trailing-comments-have-a-noun": trailing_comments_have_a_noun,
    "includes-have-one-style": includes_have_one_style,
}
