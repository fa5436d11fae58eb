"""The folder in which a run keeps its results. The plots are made of them.

NAME.json has the figures of a benchmark, as its option --json writes them. The files of benchmarks.FILES have further
data for the plots. about.json contains for each benchmark when, where and with which command it was measured. A later
run of a benchmark replaces its files only."""

import csv
import json
import os
import shutil
from dataclasses import dataclass, field

import benchmarks

ABOUT = "about.json"


@dataclass
class Records:
    figures: dict = field(default_factory=dict)  # the output of --json, by the name of the benchmark
    tables: dict = field(default_factory=dict)  # the rows of each file of comma-separated values by its name
    about: dict = field(default_factory=dict)  # by the name of the benchmark: texts by their titles

    def figure(self, bench, name):
        """Returns a figure; None if there is no such figure."""
        return next((one for one in self.figures.get(bench, []) if one.get("name") == name), None)


def options_for_files(name, free, folder):
    """Returns the arguments that make a benchmark write its further files to `folder`, if it has the option for that.
    `free`: the options that the caller does not set itself."""
    option, file = benchmarks.FILES.get(name, (None, None))
    return [option, os.path.join(folder, file)] if option in free else []


def keep(folder, name, figures, about, written):
    """Keeps the results of one benchmark. `written`: the folder that options_for_files() got."""
    os.makedirs(folder, exist_ok=True)
    write_json(os.path.join(folder, name + ".json"), figures)
    all_about = read_json(os.path.join(folder, ABOUT), {})
    write_json(os.path.join(folder, ABOUT), {**all_about, name: about})
    _, file = benchmarks.FILES.get(name, (None, None))
    if file and os.path.isfile(os.path.join(written, file)):
        shutil.copyfile(os.path.join(written, file), os.path.join(folder, file))
    elif file and os.path.isfile(os.path.join(folder, file)):
        os.remove(os.path.join(folder, file))  # it is of an earlier run, which `about` does not describe


def load(folder, names=None):
    """Reads the records of the benchmarks in `names`, or of all."""
    names = [benchmark.name for benchmark in benchmarks.ALL] if names is None else names
    records = Records(about=read_json(os.path.join(folder, ABOUT), {}))
    for name in names:
        figures = read_json(os.path.join(folder, name + ".json"), None)
        if figures is not None:
            records.figures[name] = figures
        _, file = benchmarks.FILES.get(name, (None, None))
        if file and os.path.isfile(os.path.join(folder, file)):
            with open(os.path.join(folder, file), encoding="utf-8", newline="") as opened:
                records.tables[file] = list(csv.DictReader(opened))
    return records


def read_json(path, otherwise):
    if not os.path.isfile(path):
        return otherwise
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def write_json(path, content):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1)
        file.write("\n")
