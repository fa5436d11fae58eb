"""Splits C and C++ into tokens, comments and lines, as precisely as the checks need it."""

import functools
import re
from typing import NamedTuple

# Frequent kinds come first, for speed.
_PIECES = re.compile(
    r"""(?P<word>(?!(?:u8|u|U|L)?R")[A-Za-z_]\w*)"""
    r"|(?P<line_end>\n)"
    r"|(?P<symbol>::|->|\[\[|\]\]|==|<=|>=|!=|&&|\|\||[-+*%^&|]=|<<|[^\s\w/#\"'])"
    r"|(?P<comment>//(?:\\\n|[^\n])*|/\*(?:.|\n)*?\*/)"
    r'|(?P<string>"(?:[^"\\\n]|\\(?:.|\n))*")'
    r"|(?P<number>\b\d(?:'?[\w.])*)"
    r'|(?P<raw>\b(?:u8|u|U|L)?R"(?P<mark>[^()\\ \n]*)\((?:.|\n)*?\)(?P=mark)")'
    r"|(?P<character>'(?:\\.|[^'\\\n])+')"
    r"|(?P<preprocessor>^[ \t]*\#(?:\\\n|/\*(?:.|\n)*?\*/|(?!//|/\*)[^\n])*)"
    r"|(?P<other>/=|[^\s\w])",
    re.MULTILINE)
_KINDS = {"raw": "string", "mark": "string", "other": "symbol"}


class Token(NamedTuple):
    kind: str  # word, number, string, character, symbol
    text: str
    line: int


class Comment(NamedTuple):
    text: str
    line: int
    column: int
    own_line: bool  # true if only white space precedes the comment in its line


class Source(NamedTuple):
    tokens: list
    comments: list


@functools.lru_cache(maxsize=None)
def read(text):
    tokens, comments = [], []
    line = 1
    for piece in _PIECES.finditer(text):
        kind, found = piece.lastgroup, piece[0]
        if kind in ("word", "symbol"):
            tokens.append(Token(kind, found, line))
        elif kind == "line_end":
            line += 1
        else:
            if kind == "comment":
                begin = text.rfind("\n", 0, piece.start()) + 1
                before = text[begin:piece.start()]
                comments.append(Comment(found, line, len(before), not before.strip()))
            elif kind != "preprocessor":
                tokens.append(Token(_KINDS.get(kind, kind), found, line))
            line += found.count("\n")
    return Source(tokens, comments)


class LineCounts(NamedTuple):
    code: int
    comment: int
    blank: int


def count_lines(text):
    """Counts lines of code and of comments. A line with both is a line of code."""
    lines = text.splitlines()
    with_code, with_comment = set(), set()
    for piece in _PIECES.finditer(text):
        if piece.lastgroup == "line_end":
            continue
        first = text.count("\n", 0, piece.start()) + 1
        last = first + piece.group().count("\n")
        (with_comment if piece.lastgroup == "comment" else with_code).update(range(first, last + 1))
    with_comment -= with_code
    blank = sum(1 for line in lines if not line.strip())
    return LineCounts(len(lines) - len(with_comment) - blank, len(with_comment), blank)
