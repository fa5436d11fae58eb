"""Finds comments that begin in the middle of a sentence.

A block is a run of lines that hold nothing but a // or /// comment, in the same column. A comment behind code is no
block, even if it continues in the next lines, and neither is a ///< comment. A block begins in mid-sentence if its
first word is

- a word with which clauses and phrases begin, or a pronoun, since nothing was named before it (FRAGMENT); or
- written in lower case, unless it is a name: it occurs in the code of the file, rooms.toml lists it (programs, system
  calls), or its spelling is not that of an English word (snake_case, `quoted`, call(), a::b).
"""

import re
from typing import NamedTuple

import lexer

FRAGMENT = set("""
    and as because behind but by else for from had has have how in instead into is it its itself lest like neither nor
    of on or rather so than that their them then they thereby those though through thus to under unless until upon was
    were what whatever when whence whenever where whereas whereby wherein wherever whether which whichever while who
    whoever whom whose why with without yet
    """.split())
# Whole sentences may also begin with these words if they have a comma: `When the window is full, the sender waits.`
CLAUSE = set("""
    because behind by for from in instead like on though through to under unless until upon when whenever while with
    without
    """.split())
_TRAILING = "///<"


class Block(NamedTuple):
    line: int
    text: str


def blocks(text):
    source = lexer.read(text)
    found, column, last, skipping = [], 0, -1, False
    for comment in source.comments:
        if not comment.text.startswith("//"):
            last = -1
            continue
        goes_on = comment.line == last + 1 and comment.column == column and comment.own_line
        last, column = comment.line, comment.column
        if goes_on:
            if not skipping:
                found[-1][1].append(_words(comment.text))
            continue
        skipping = not comment.own_line or comment.text.startswith(_TRAILING)
        if not skipping:
            found.append((comment.line, [_words(comment.text)]))
    return [Block(line, "\n".join(words).strip()) for line, words in found if any(words)]


def _words(comment):
    return comment.replace("\\\n", "\n").lstrip("/").strip()


def names_in(text):
    return {token.text for token in lexer.read(text).tokens if token.kind == "word"}


def begins_in_mid_sentence(block, names):
    """Returns true if the block begins in mid-sentence. Words in `names` need no capital letter."""
    first = block.text.split(maxsplit=1)[0]
    word = re.match(r"[A-Za-z]+(?:'[a-z]+)?(?=$|[^\w])", first)
    if not word:
        return False  # a number, a name in quotes, snake_case
    word = word[0].removesuffix("'s")
    if word.lower() in FRAGMENT:
        return not (word.lower() in CLAUSE and word[0].isupper() and "," in _first_sentence(block.text))
    if not word[0].islower():
        return False
    return not (word in names or re.search(r"[a-z]\.[a-z]|::|[(/\[<>=]|[a-z][A-Z]", first))


def _first_sentence(text):
    return re.split(r"[.:;](?:\s|$)", text, maxsplit=1)[0]
