"""The table of figures about a checkout."""

import os
import re

import checks
import headers
import lexer
import rooms
import structure

PRODUCT = ("core/", "udp_transport/", "shm_transport/", "typesupport/", "tools/", "sft/")
NOT_PRODUCT = ("typesupport/interfaces/", "tools/demo/")


def table(tree, settings):
    for name, value in _rows(tree, settings):
        yield f"{name:<34}{value}"


def _rows(tree, settings):
    yield from _lengths(tree)
    yield from _classes(tree)
    yield from _arrows(tree, settings)
    yield from _comments(tree, settings)
    yield from _readme(tree)
    yield from _product(tree)
    yield "public headers", len(headers.public_headers(tree, settings))
    detail = sum(map(headers.is_detail, headers.public_headers(tree, settings)))
    yield "  of these in detail/", detail
    yield "public types in namespaces", len(list(headers.public_types(tree, settings)))


def is_product(path):
    return path.startswith(PRODUCT) and not path.startswith(NOT_PRODUCT)


def _lengths(tree):
    yield "files", len(tree.files)
    yield "  C and C++", len(tree.code)
    yield "lines of C and C++", f"{sum(len(tree.lines(path)) for path in tree.code):,}"
    yield "lines per file", _spread([(len(tree.lines(path)), path) for path in tree.code])
    functions = [(function.lines, f"{function.name} in {path}")
                 for path in tree.code for function in structure.read(tree.text(path)).functions]
    yield "functions", f"{len(functions):,}"
    yield "lines per function", _spread(functions)


def _spread(values):
    values = sorted(values)
    if not values:
        return "none"
    numbers = [number for number, _ in values]
    median, p90 = numbers[len(numbers) // 2], numbers[min(len(numbers) * 9 // 10, len(numbers) - 1)]
    return f"median {median}, p90 {p90}, max {values[-1][0]} ({values[-1][1]})"


def _classes(tree):
    classes = [(made.data, made.methods, made.name, path)
               for path in tree.code for made in structure.read(tree.text(path)).classes]
    yield "classes", f"{len(classes):,}"
    for title, order in (("most data members", lambda c: c[0]), ("most methods", lambda c: c[1])):
        yield title, "(data members, methods)"
        for data, methods, name, path in sorted(classes, key=order, reverse=True)[:10]:
            yield f"  {name}", f"{data:>3} {methods:>3}  {path}"


def _arrows(tree, settings):
    includes = rooms.Includes(tree, settings)
    product = [path for path in tree.code if is_product(path)]
    folders = {os.path.dirname(path) for path in product}
    between = {(a, b) for a, b in rooms.arrows(includes, os.path.dirname) if {a, b} <= folders}
    yield "folders of the product", len(folders)
    yield "arrows between them", len(between)
    plan = rooms.Rooms(settings.rooms)
    yield "includes upward", len(list(rooms.upward(includes, plan)))
    yield "files in no room", sum(1 for path in tree.code if not plan.room_of(path))
    knots = rooms.knots(includes)
    yield "knots", f"{len(knots)}" + "".join(f"; {len(knot)} pairs around {knot[0]}" for knot in knots)


def _comments(tree, settings):
    blocks = [is_fragment for _, _, is_fragment in checks.comment_blocks(tree, settings)]
    percent = 100 * sum(blocks) / max(len(blocks), 1)
    yield "comments that begin in mid-sentence", f"  {sum(blocks)} of {len(blocks)} blocks, {percent:.1f} %"


def _readme(tree):
    if "README.md" not in tree.files:
        return
    text = tree.text("README.md")
    code = re.findall(r"^```.*?^```", text, re.MULTILINE | re.DOTALL)
    in_code = sum(len(block.split()) for block in code)
    words, lines = len(text.split()) - in_code, len(text.splitlines())
    yield "README.md", f"{words:,} words, {in_code:,} in blocks of code, {lines} lines"


def _product(tree):
    total = lexer.LineCounts(0, 0, 0)
    by_folder = {}
    for path in filter(is_product, tree.code):
        counts = lexer.count_lines(tree.text(path))
        total = lexer.LineCounts(*map(sum, zip(total, counts)))
        by_folder[path.split("/")[0]] = by_folder.get(path.split("/")[0], 0) + sum(counts)
    kinds = f"code {total.code:,}, comments {total.comment:,}, blank {total.blank:,}"
    yield "lines of the product", f"{sum(total):,}: {kinds}"
    for folder, lines in by_folder.items():
        yield f"  {folder}", f"{lines:,}"
