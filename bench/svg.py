"""Charts as parts of an SVG. Pure functions: they run and read nothing.

A chart is 420 units wide, so that its text is readable on a telephone. Its colours follow the reader's settings.
Contenders have the same colour and dashes in all charts."""

import math
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

WIDTH = 420
LEFT, RIGHT = 100, 360  # the ends of the axis of a bar chart
LINE = 14  # the height of a line of text

STYLE = """
svg.plot { --ink: #1b1f24; --paper: #ffffff; --line: #d0d7de; --faint: #59636e; --c0: #0969da; --c1: #bc4c00;
  --c2: #8250df; --c3: #1a7f37; --c4: #bf3989; --c5: #6e7781; color-scheme: light dark; color: var(--ink);
  background: var(--paper); }
@media (prefers-color-scheme: dark) { svg.plot { --ink: #e6edf3; --paper: #0d1117; --line: #30363d; --faint: #9198a1;
  --c0: #58a6ff; --c1: #f0883e; --c2: #bc8cff; --c3: #3fb950; --c4: #f778ba; --c5: #8b949e; } }
svg.plot text { fill: currentColor; font: 11px system-ui, -apple-system, 'Segoe UI', 'DejaVu Sans', sans-serif; }
svg.plot .title { font-weight: 600; font-size: 13px; }
svg.plot .faint { fill: var(--faint); font-size: 9px; }
svg.plot .grid { stroke: var(--line); stroke-width: 1; }
svg.plot .curve { fill: none; stroke-width: 2; }
svg.plot .band { opacity: 0.18; }
""" + "".join(f"svg.plot .fill{i} {{ fill: var(--c{i}); }} svg.plot .stroke{i} {{ stroke: var(--c{i}); }}\n"
              for i in range(6))

COLOURS = {"SFT": 0, "Cyclone DDS": 1, "Fast DDS": 2, "iceoryx": 3, "UDP": 4, "TCP": 5}
DASHES = ("", "7 3", "2 3", "9 3 2 3", "4 2", "1 2")


def is_positive(value):
    return isinstance(value, (int, float)) and math.isfinite(value) and value > 0


def colour(name):
    """Returns the colour of the contender with which the name begins: "SFT, two fields" has the colour of SFT."""
    return next((number for known, number in COLOURS.items() if name.startswith(known)), len(COLOURS) - 1)


def number(value):
    """Returns the value with three digits: "0.0123", "1.23", "12,300"."""
    digits = 2 - math.floor(math.log10(abs(value))) if value else 0
    return f"{round(value, digits):,.{max(0, digits)}f}"


def power(value):
    """Returns the label of a decade: "0.01", "10", "10k", "1M"."""
    for limit, unit in ((1e6, "M"), (1e4, "k")):
        if value >= limit:
            return f"{value / (limit if unit == 'M' else 1e3):,.0f}{unit}"
    return f"{value:g}"


@dataclass
class Part:
    """A part of a chart, with its height."""

    height: float
    elements: list = field(default_factory=list)

    def text(self, x, y, words, anchor="start", kind="", turned=False):
        kind = f' class="{kind}"' if kind else ""
        turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
        self.elements.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{kind}{turn}>{escape(words)}</text>')

    def line(self, x1, y1, x2, y2, kind="grid", dashes=""):
        dashes = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.elements.append(
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" class="{kind}"{dashes}/>')

    def path(self, points, kind, dashes="", closed=False):
        words = " L ".join(f"{x:.1f} {y:.1f}" for x, y in points)
        dashes = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.elements.append(f'<path d="M {words}{" Z" if closed else ""}" class="{kind}"{dashes}/>')


class LogScale:
    """Maps values to positions. The scale ends at powers of ten, or at the least and the greatest value."""

    def __init__(self, values, begin, end, whole_decades=True):
        low, high = math.log10(min(values)), math.log10(max(values))
        if whole_decades:
            low, high = math.floor(low + 1e-9), math.ceil(high - 1e-9)
        if high - low < 1e-9:
            low, high = low - (0.0 if whole_decades else 0.5), high + (1.0 if whole_decades else 0.5)
        self.low, self.high, self.begin, self.end = low, high, begin, end

    def at(self, value):
        return self.begin + (math.log10(value) - self.low) / (self.high - self.low) * (self.end - self.begin)

    def decades(self):
        """Returns at most seven powers of ten within the scale."""
        numbers = range(math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9) + 1)
        return [10.0**number for number in numbers[::math.ceil(len(numbers) / 7)]]


def bars(groups, axis):
    """Draws horizontal bars on a logarithmic scale, which begin at a power of ten below all values.

    `groups`: pairs of a heading and a list of pairs (contender, value). A missing value is shown as missing."""
    values = [value for _, rows in groups for _, value in rows if is_positive(value)]
    part = Part(sum(LINE * (len(rows) + 1) + 6 for _, rows in groups) + 2 * LINE + 8)
    if not values:
        return nothing()
    scale = LogScale([min(values) / 1.5, *values], LEFT, RIGHT)
    bottom = part.height - 2 * LINE - 6
    for decade in scale.decades():
        part.line(scale.at(decade), 2, scale.at(decade), bottom)
        part.text(scale.at(decade), bottom + LINE - 1, power(decade), "middle")
    part.text((LEFT + RIGHT) / 2, part.height - 4, axis, "middle")
    y = 0
    for heading, rows in groups:
        y += LINE
        part.text(4, y - 2, heading)
        for name, value in rows:
            part.text(LEFT - 6, y + LINE - 3, name, "end")
            if is_positive(value):
                end = max(LEFT + 1, scale.at(value))
                part.elements.append(f'<rect x="{LEFT}" y="{y + 2:.1f}" width="{end - LEFT:.1f}" height="{LINE - 4}" '
                                     f'class="fill{colour(name)}"/>')
                part.text(end + 4, y + LINE - 3, number(value))
            else:
                part.text(LEFT + 4, y + LINE - 3, "0" if value == 0 else "no value", kind="faint")
            y += LINE
        y += 6
    return part


def curves(series, x_axis, y_axis, x_label=power, height=220):
    """Draws curves on logarithmic scales.

    `series`: pairs of a name and a list of points (x, y) or (x, y, upper), in the order of x. With upper ends, a band
    is drawn, too."""
    series = [(name, [point for point in points if all(map(is_positive, point))]) for name, points in series]
    series = [(name, points) for name, points in series if points]
    if not series:
        return nothing()
    rows = (len(series) + 1) // 2
    top, bottom, left, right = LINE * rows + 8, LINE * rows + 8 + height, 52, WIDTH - 12
    part = Part(bottom + 2 * LINE + 6)
    xs = sorted({point[0] for _, points in series for point in points})
    across = LogScale(xs, left + 6, right - 6, whole_decades=False)
    up = LogScale([end for _, points in series for point in points for end in point[1:]], bottom, top)
    for decade in up.decades():
        part.line(left, up.at(decade), right, up.at(decade))
        part.text(left - 4, up.at(decade) + 4, power(decade), "end")
    for x in xs:
        part.line(across.at(x), bottom, across.at(x), bottom + 4)
        part.text(across.at(x), bottom + LINE + 2, x_label(x), "middle")
    part.text((left + right) / 2, part.height - 4, x_axis, "middle")
    part.text(11, (top + bottom) / 2, y_axis, "middle", turned=True)
    for i, (name, points) in enumerate(series):
        shade = colour(name)
        dashes = DASHES[sum(colour(other) == shade for other, _ in series[:i]) % len(DASHES)]
        places = [(across.at(point[0]), up.at(point[1])) for point in points]
        if any(point[-1] > point[1] for point in points if len(point) == 3):
            upper = [(across.at(point[0]), up.at(point[2])) for point in points]
            part.path(places + upper[::-1], f"band fill{shade}", closed=True)
        part.path(places, f"curve stroke{shade}", dashes)
        part.elements += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" class="fill{shade}"/>' for x, y in places]
        legend_x, legend_y = left + (i % 2) * (right - left) / 2, LINE * (i // 2) + LINE - 4
        part.path([(legend_x, legend_y - 4), (legend_x + 22, legend_y - 4)], f"curve stroke{shade}", dashes)
        part.text(legend_x + 27, legend_y, name)
    return part


def nothing():
    part = Part(2 * LINE)
    part.text(4, LINE + 2, "This run has none of these figures.", kind="faint")
    return part


def picture(title, part, notes):
    """Returns the whole file, with the style that defines its colours."""
    top, height = 22, 22 + part.height + 11 * len(notes) + 8
    frame = Part(height)
    frame.text(4, 15, title, kind="title")
    for i, note in enumerate(notes):
        frame.text(4, top + part.height + 11 * (i + 1), note, kind="faint")
    size = f' xmlns="http://www.w3.org/2000/svg" width="{1.5 * WIDTH:.0f}" height="{1.5 * height:.0f}"'
    return "\n".join([f'<svg class="plot" viewBox="0 0 {WIDTH} {height:.0f}" role="img"{size}>',
                      f"<title>{escape(title)}</title><style>{STYLE}</style>",
                      f'<rect width="{WIDTH}" height="{height:.0f}" rx="6" style="fill: var(--paper)"/>',
                      *frame.elements, f'<g transform="translate(0 {top})">', *part.elements, "</g></svg>", ""])
