#!/usr/bin/env python3
"""Draws the picture of README.md, light.svg and dark.svg, from the figures of a run of the demo, demo.json.

    ./run demo --json docs/picture/demo.json     # measures anew
    docs/picture/draw.py                         # draws both files
    docs/picture/draw.py --check                 # only says whether both files show the figures; a test does that
"""

import json
import math
import pathlib
import sys
from xml.sax.saxutils import escape

FOLDER = pathlib.Path(__file__).resolve().parent

THEMES = {
    "light": {"page": "#ffffff", "box": "#f6f8fa", "line": "#57606a", "text": "#1f2328", "quiet": "#57606a",
              "network": "#0969da", "memory": "#1a7f37", "memory_box": "#dafbe1"},
    "dark": {"page": "#0d1117", "box": "#161b22", "line": "#8b949e", "text": "#e6edf3", "quiet": "#9ea7b3",
             "network": "#58a6ff", "memory": "#3fb950", "memory_box": "#12351c"},
}

WIDTH = 800
MARGIN = 12
TOP = 48  # The boxes begin here, below the headings.
LEFT_BOX = 330  # This is the width of the publisher's host.
RIGHT_BOX = 272  # This is the width of each subscriber's host.
ROW, GAP = 66, 12  # These are the height of each subscriber's host, and the space between two of them.
TRUNK = MARGIN + LEFT_BOX + 24  # The vertical line of the network is here.


def bytes_text(count):
    """Returns a size as the demo writes it: "82 B", "6.29 MB"."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.2f} {unit}"
    return f"{count:.0f} B"


def fields_text(reader, all_fields):
    others = [name for name in all_fields if name not in reader["fields"]]
    return "all but " + ", ".join(others) if len(others) < len(reader["fields"]) / 2 else ", ".join(reader["fields"])


class Drawing:
    def __init__(self, colours, height):
        self.colours = colours
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}"'
            ' font-family="system-ui, -apple-system, \'Segoe UI\', \'DejaVu Sans\', sans-serif">',
            f'<rect width="{WIDTH}" height="{height}" rx="8" fill="{colours["page"]}"/>']

    def box(self, x, y, width, height, fill="box", line="line"):
        self.parts.append(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" '
                          f'fill="{self.colours[fill]}" stroke="{self.colours[line]}"/>')

    def text(self, x, y, words, colour="text", size=14, bold=False, anchor="start"):
        weight = ' font-weight="600"' if bold else ""
        self.parts.append(f'<text x="{x}" y="{y}" font-size="{size}" text-anchor="{anchor}"{weight} '
                          f'fill="{self.colours[colour]}">{escape(words)}</text>')

    def line(self, points, colour, width):
        path = " L ".join(f"{x} {y}" for x, y in points)
        self.parts.append(f'<path d="M {path}" fill="none" stroke="{self.colours[colour]}" stroke-width="{width:g}"/>')

    def arrow(self, points, colour, width):
        """Draws a line with an arrow. Its last segment goes to the right or down."""
        (x, y), (from_x, _) = points[-1], points[-2]
        size = 5 + width / 2
        right = x != from_x
        end = (x - size, y) if right else (x, y - size)
        self.line([*points[:-1], end], colour, width)
        head = [(end[0], y - size), (end[0], y + size)] if right else [(x - size, end[1]), (x + size, end[1])]
        corners = " ".join(f"{a:g},{b:g}" for a, b in [(x, y), *head])
        self.parts.append(f'<polygon points="{corners}" fill="{self.colours[colour]}"/>')

    def svg(self):
        return "\n".join([*self.parts, "</svg>", ""])


def draw(figures, colours):
    readers = figures["subscribers"]
    local = [r for r in readers if r["transport"] == "shm"]
    remote = [r for r in readers if r["transport"] != "shm"]
    all_fields = list(dict.fromkeys(name for r in readers for name in r["fields"] if "." not in name))
    bottom = TOP + len(remote) * (ROW + GAP) - GAP
    drawing = Drawing(colours, bottom + 50)
    draw_own_host(drawing, figures, local, all_fields, bottom)
    draw_other_hosts(drawing, figures, remote, all_fields, bottom)
    saved = math.floor(1000 * (1 - figures["carried_bytes"] / figures["whole_bytes"])) / 10
    drawing.text(WIDTH / 2, bottom + 34,
                 f"The network carried {bytes_text(figures['carried_bytes'])} instead of "
                 f"{bytes_text(figures['whole_bytes'])}: {saved} % saved", bold=True, size=16, anchor="middle")
    return drawing.svg()


def draw_own_host(drawing, figures, local, all_fields, bottom):
    whole = bytes_text(local[0]["full_bytes_per_sample"])
    drawing.text(MARGIN, TOP - 14, "The host of the publisher", "quiet")
    drawing.box(MARGIN, TOP, LEFT_BOX, bottom - TOP)
    x, width, middle = MARGIN + 18, LEFT_BOX - 36, MARGIN + LEFT_BOX / 2
    drawing.box(x, TOP + 16, width, 56, "page")
    drawing.text(x + 12, TOP + 40, "lidar", bold=True)
    drawing.text(x + 12, TOP + 60, f"publishes {figures['samples']} clouds of {whole}", "quiet")
    drawing.arrow([(middle, TOP + 72), (middle, TOP + 112)], "memory", 2.5)
    drawing.text(middle + 14, TOP + 96, f"{whole}, encoded once", "memory", bold=True)
    memory = TOP + 112
    drawing.box(x, memory, width, 56, "memory_box", "memory")
    drawing.text(x + 12, memory + 24, "one sample in shared memory", bold=True)
    drawing.text(x + 12, memory + 44, "all readers of this host read it in place", "quiet")
    for i, reader in enumerate(local):
        y = bottom - 16 - (len(local) - i) * (56 + GAP) + GAP
        drawing.box(x, y, width, 56, "page")
        drawing.text(x + 12, y + 24, reader["name"], bold=True)
        drawing.text(x + 12, y + 44, fields_text(reader, all_fields), "quiet")
    first = bottom - 16 - len(local) * (56 + GAP) + GAP
    drawing.arrow([(middle, memory + 56), (middle, first)], "memory", 2.5)
    drawing.text(middle + 14, (memory + 56 + first) / 2 + 5,
                 f"{bytes_text(local[0]['wire_bytes_per_sample'])} sent", "memory", bold=True)


def draw_other_hosts(drawing, figures, remote, all_fields, bottom):
    x = WIDTH - MARGIN - RIGHT_BOX
    drawing.text(x, TOP - 14, "Other hosts", "quiet")
    drawing.text(TRUNK, TOP - 14, "UDP, only these fields", "network")
    rows = [TOP + i * (ROW + GAP) + ROW / 2 for i in range(len(remote))]
    memory = TOP + 112 + 28
    drawing.line([(MARGIN + LEFT_BOX - 18, memory), (TRUNK, memory)], "network", 2.5)
    drawing.line([(TRUNK, rows[0] - 1), (TRUNK, rows[-1])], "network", 2.5)
    for reader, y in zip(remote, rows):
        sent = reader["wire_bytes_per_sample"]
        drawing.arrow([(TRUNK, y), (x, y)], "network", 1 + math.log10(max(10, sent)) / 1.5)
        drawing.text(TRUNK + 12, y - 10, f"{bytes_text(sent)} a cloud", "network", bold=True)
        if reader["received"] < figures["samples"]:
            drawing.text(TRUNK + 12, y + 21, f"{reader['received']} clouds of {figures['samples']}", "network")
        drawing.box(x, y - ROW / 2, RIGHT_BOX, ROW)
        drawing.text(x + 12, y - 5, reader["name"], bold=True)
        drawing.text(x + 12, y + 17, fields_text(reader, all_fields), "quiet")


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    figures = json.loads((FOLDER / "demo.json").read_text(encoding="utf-8"))
    for name, colours in THEMES.items():
        file, svg = FOLDER / f"{name}.svg", draw(figures, colours)
        if not arguments:
            file.write_text(svg, encoding="utf-8")
        elif not file.exists() or file.read_text(encoding="utf-8") != svg:
            print(f"{file} does not show the figures of demo.json: run docs/picture/draw.py", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
