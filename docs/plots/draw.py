#!/usr/bin/env python3
"""Draws the plots of docs/performance.md from the figures in docs/plots/data.

    ./run bench all --only NAME,NAME --keep docs/plots/data    # measures anew
    docs/plots/draw.py                                         # draws all files
    docs/plots/draw.py --check                                 # only says whether the files show the figures
"""

import pathlib
import sys

sys.dont_write_bytecode = True
FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parents[1] / "bench"))

import plots
import records


def main(words):
    wrong = []
    drawn = {f"{plot.name}.svg": plot.svg() for plot in plots.all_plots(records.load(FOLDER / "data"))}
    for name, text in drawn.items():
        file = FOLDER / name
        if "--check" not in words:
            file.write_text(text, encoding="utf-8")
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            wrong.append(f"{name} does not show the figures; run docs/plots/draw.py")
    wrong += [f"{file.name} has no figures; delete it" for file in FOLDER.glob("*.svg") if file.name not in drawn]
    for line in wrong:
        print(f"docs/plots: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
