"""One page of HTML with the figures of all benchmarks. Pure functions: nothing is run or read here.

The page is one file without scripts, and needs nothing from anywhere else. It is readable on a telephone and in the
dark: colours follow the reader's settings, and wide tables scroll within the page. bench/plots.py says which plots
there are."""

import html
import math

import comparison
import plots
import svg

# The longest bar stands for this ratio, and as much to the other side of 1: ratios are shown by their logarithm.
RATIO_MAX = 32.0
BAR_WIDTH, BAR_HEIGHT = 160, 12

STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #ffffff; --line: #d0d7de; --good: #1a7f37; --bad: #cf222e;
        --faint: #6e7781; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6edf3; --paper: #0d1117; --line: #30363d; --good: #3fb950; --bad: #f85149; --faint: #8b949e; } }
body { font: 16px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 1rem auto;
       max-width: 62rem; padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
td, th { border-bottom: 1px solid var(--line); padding: .25rem .6rem; text-align: right; white-space: nowrap; }
td:first-child, th:first-child { text-align: left; }
.good { color: var(--good); } .bad { color: var(--bad); } .faint { color: var(--faint); }
svg .good { fill: var(--good); } svg .bad { fill: var(--bad); } td line { stroke: var(--line); }
code { overflow-wrap: anywhere; }
figure { margin: 1rem 0; } svg.plot { width: 100%; max-width: 40rem; height: auto; }
""" + svg.STYLE


def number(value):
    """Four digits, or a dash where a benchmark has no value."""
    if not comparison.is_number(value):
        return "–"
    if value == 0:
        return "0"
    digits = max(0, 3 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(digits, 6)}f}"


def lower_is_better(figure):
    """None if the unit does not tell. A bound tells, too: values are to stay below it, or above it."""
    if figure.get("bound") is not None:
        return not figure.get("at_least", False)
    kind = comparison.UNITS.get(figure["unit"])
    return None if kind is None else kind == comparison.LOWER


def meets_bound(figure):
    """None if there is no bound, or no value."""
    if figure.get("bound") is None:
        return None
    measured = figure["value"] if figure.get("bound_of") == "value" else figure.get("ratio")
    if not comparison.is_number(measured):
        return None
    return measured >= figure["bound"] if figure.get("at_least") else measured <= figure["bound"]


def is_behind(figure):
    """True if the reference is better. None if the figure has none, or its unit does not tell."""
    ratio, lower = figure.get("ratio"), lower_is_better(figure)
    if not comparison.is_number(ratio) or ratio <= 0 or lower is None:
        return None
    return ratio > 1 if lower else ratio < 1


def bar(figure):
    """A bar from 1 to the ratio, on a logarithmic scale."""
    ratio = figure.get("ratio")
    if not comparison.is_number(ratio) or ratio <= 0:
        return ""
    middle = BAR_WIDTH / 2
    share = max(-1.0, min(1.0, math.log(ratio) / math.log(RATIO_MAX)))
    left, width = min(middle, middle + share * middle), max(1.0, abs(share) * middle)
    colour = {None: "", True: "bad", False: "good"}[is_behind(figure)]
    return (f'<svg width="{BAR_WIDTH}" height="{BAR_HEIGHT}" role="img" aria-label="ratio {number(ratio)}">'
            f'<rect class="{colour}" x="{left:.1f}" y="2" width="{width:.1f}" height="{BAR_HEIGHT - 4}"/>'
            f'<line x1="{middle}" x2="{middle}" y1="0" y2="{BAR_HEIGHT}"/></svg>')


def bound_of(figure):
    holds = meets_bound(figure)
    if figure.get("bound") is None:
        return ""
    sign = "≥" if figure.get("at_least") else "≤"
    text = f"{sign} {number(figure['bound'])}"
    return {None: text, True: f'<span class="good">{text}</span>',
            False: f'<span class="bad">{text}, missed</span>'}[holds]


def row(figure):
    cells = [html.escape(figure["name"]), f"{number(figure['value'])} {html.escape(figure['unit'])}",
             number(figure.get("reference")) if figure.get("reference") is not None else "",
             f'<span class="faint">{html.escape(figure.get("reference_name") or "")}</span>',
             number(figure.get("ratio")) if figure.get("ratio") is not None else "", bar(figure), bound_of(figure)]
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def table(figures):
    titles = ("figure", "SFT", "reference", "of", "ratio", "1/32 to 32, logarithmic", "bound")
    head = "<tr>" + "".join(f"<th>{title}</th>" for title in titles) + "</tr>"
    return '<div class="wide"><table>' + head + "".join(row(figure) for figure in figures) + "</table></div>"


def noise(figures):
    """What else the machine did, in words."""
    shares = {figure["name"]: figure["value"] for figure in figures if figure["name"] in comparison.NOISE}
    if not shares:
        return ""
    programs, machines = (number(shares.get(name)) for name in comparison.NOISE)
    return f"Other programs took {programs} % of the processors meanwhile, other virtual machines {machines} %. "


def plot(one):
    return f'<figure>{one.svg()}<figcaption>{html.escape(one.caption)}</figcaption></figure>'


def section(name, all_figures, about, shown):
    """`shown`: the plots of this benchmark."""
    figures = [figure for figure in all_figures if figure["name"] not in comparison.NOISE]
    behind = sorted((figure for figure in figures if is_behind(figure)), key=lambda one: one["name"])
    missed = [figure for figure in figures if meets_bound(figure) is False]
    words = f"<code>{html.escape(about['command'])}</code>: " if "command" in about else ""
    words += f"{len(figures)} figures. " + noise(all_figures)
    if behind:
        words += "The reference is better in: " + ", ".join(html.escape(one["name"]) for one in behind) + ". "
    if missed:
        words += "Bounds that do not hold: " + ", ".join(html.escape(one["name"]) for one in missed) + "."
    return (f'<h2 id="{html.escape(name)}">{html.escape(name)}</h2><p>{words}</p>' + "".join(map(plot, shown))
            + table(figures))


def page(records, about):
    """`records`: of the benchmarks that ran. `about`: texts about the whole run by their titles."""
    rows = "".join(f"<tr><td>{html.escape(title)}</td><td><code>{html.escape(text)}</code></td></tr>"
                   for title, text in about.items())
    links = " · ".join(f'<a href="#{html.escape(name)}">{html.escape(name)}</a>' for name in records.figures)
    all_plots = plots.all_plots(records)
    sections = [section(name, figures, records.about.get(name, {}), [one for one in all_plots if one.bench == name])
                for name, figures in records.figures.items()]
    return ('<!doctype html><html lang="en"><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1"><title>SFT benchmarks</title>'
            f"<style>{STYLE}</style><h1>SFT benchmarks</h1>"
            '<p>A ratio is a figure of SFT over that of the reference, which was measured in the same run. '
            '<span class="good">Green</span>: SFT is better. <span class="bad">Red</span>: the reference is. '
            'Below each plot stands where a peer is better.</p>'
            f'<div class="wide"><table>{rows}</table></div><p>{links}</p>' + "".join(sections) + "</html>\n")
