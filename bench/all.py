#!/usr/bin/env python3
"""Runs all benchmarks one after the other, or compares their figures with those of another commit.

With --against, the commit is checked out and built in build/against/COMMIT, where it stays for the next time. Both
sides run in turns (this, that, that, this ...). A table says what is worse, better and the same, by more than the
noise that the rounds show; bench/comparison.py says how."""

import argparse
import json
import os
import platform
import shlex
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # no files beside the sources
import benchmarks
import comparison
import processes
import records
import trees

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def say(*words):
    print(*words, file=sys.stderr, flush=True)


def parse(words):
    names = [benchmark.name for benchmark in benchmarks.ALL]
    parser = argparse.ArgumentParser(
        prog="./run bench all", usage="./run bench all [OPTION...] [-- ARGUMENT...]", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Behind -- are arguments for all benchmarks; one that does not know an argument runs without it.")
    parser.add_argument("--against", metavar="COMMIT", help="compare this tree with this commit")
    parser.add_argument("--rounds", type=int, metavar="N",
                        help=f"times that each side runs each benchmark (default: {benchmarks.ROUNDS}, with --quick "
                             f"{benchmarks.QUICK_ROUNDS})")
    parser.add_argument("--quick", action="store_true", help="short runs of each benchmark, about 12 minutes a side")
    parser.add_argument("--only", metavar="NAME,NAME", help="these benchmarks only, of " + ",".join(names))
    parser.add_argument("--json", metavar="FILE", help="also write the figures or the comparison to this file")
    parser.add_argument("--keep", metavar="DIR",
                        help="also keep what plots are made of in this folder, beside what earlier runs of "
                             "other benchmarks left there; not with --against")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS",
                        help="end a run of a benchmark that takes longer (default: four times its usual time)")
    parser.add_argument("--fail-above", type=float, metavar="PERCENT",
                        help="exit code 1 if a figure is clearly worse, and by more than this")
    own, further = (words[:words.index("--")], words[words.index("--") + 1:]) if "--" in words else (words, [])
    arguments = parser.parse_args(own)
    arguments.further = further
    wanted = arguments.only.split(",") if arguments.only else names
    for name in set(wanted) - set(names):
        parser.error(f"no benchmark is called '{name}'; there are: {', '.join(names)}")
    arguments.benchmarks = [benchmark for benchmark in benchmarks.ALL if benchmark.name in wanted]
    if arguments.against is None:
        for option in ("rounds", "fail_above"):
            if getattr(arguments, option) is not None:
                parser.error(f"--{option.replace('_', '-')} needs --against")
    elif arguments.keep:
        parser.error("--keep is for the figures of this tree; a comparison has none")
    if arguments.rounds is None:
        arguments.rounds = benchmarks.QUICK_ROUNDS if arguments.quick else benchmarks.ROUNDS
    if arguments.rounds < 1:
        parser.error("--rounds takes a number above 0")
    return arguments


def options_among(words):
    """Returns a pair for each option: its name, and the words that give it (`--rounds 2`, `--rounds=2`)."""
    options = []
    for word in words:
        if word.startswith("--") or not options:
            options.append((word.partition("=")[0], [word]))
        else:
            options[-1][1].append(word)
    return options


class Session:
    """Runs benchmarks, and collects the problems that kept some from running."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.problems = []

    def problem(self, text):
        say(f"run: {text}")
        self.problems.append(text)

    def build(self, tree, names):
        """Builds these benchmarks, and returns the names of those that exist and build."""
        say(f"Building {tree.title}")
        missing = [name for name in names if not tree.has(name)]
        for name in missing:
            self.problem(f"{tree.title} has no benchmark {name}")
        names = [name for name in names if name not in missing]
        broken = tree.build(names) if names else []
        for name in broken:
            self.problem(f"bench_{name} of {tree.title} does not build")
        return [name for name in names if name not in broken]

    def words_for(self, benchmark, sides):
        """Returns the arguments of a benchmark, which all sides get; None if one of them refuses a value."""
        words = []
        of_sides = [(tree, tree.options(benchmark.name)) for tree in sides]
        given = options_among(self.arguments.further)
        quick = options_among(benchmark.quick) if self.arguments.quick else []
        for option, parts in [one for one in quick if one[0] not in dict(given)] + given:
            lacking = [tree.title for tree, options in of_sides if option not in options]
            if lacking:
                say(f"run: {benchmark.name} runs without {option}, which it lacks in {' and '.join(lacking)}")
                continue
            value = parts[-1].partition("=")[2] if len(parts) == 1 else parts[-1]
            for tree, options in of_sides:
                if options[option] and not set(value.split(",")) <= set(options[option]):
                    say(f"run: {benchmark.name} is left out: {option} takes no '{value}' in {tree.title}")
                    return None
            words += parts
        return words

    def limit_s(self, benchmark):
        return self.arguments.time_limit or benchmark.limit_s(self.arguments.quick)

    def run(self, tree, benchmark, words, out):
        figures, problem = tree.run(benchmark.name, words, self.limit_s(benchmark), out)
        if figures is None:
            self.problem(f"bench_{benchmark.name} of {tree.title} {problem}")
        return figures


def run_all(session, this, folder):
    """Runs all benchmarks, keeps the records of each in the folder when it has ended, and returns all records."""
    names = []
    about = about_this_machine(this.root)
    built = session.build(this, [benchmark.name for benchmark in session.arguments.benchmarks])
    for benchmark in session.arguments.benchmarks:
        words = session.words_for(benchmark, [this]) if benchmark.name in built else None
        if words is None:
            continue
        print(f"== {benchmark.name}", flush=True)
        with tempfile.TemporaryDirectory(prefix="sft_bench_") as written:
            free = set(this.options(benchmark.name)) - {option for option, _ in options_among(words)}
            further = records.options_for_files(benchmark.name, free, written)
            begin = time.monotonic()
            found = session.run(this, benchmark, further + words, None)
            if found is None:
                continue
            seconds = time.monotonic() - begin
            say(f"{benchmark.name} took {seconds:.0f} s")
            records.keep(folder, benchmark.name, found,
                         {"command": shlex.join(["./run", "bench", benchmark.name, *words]),
                          "date": time.strftime("%Y-%m-%d"), "took": f"{seconds:.0f} s", **about}, written)
            names.append(benchmark.name)
    return records.load(folder, names)


def measure_both(session, this, that, benchmark, words):
    """Returns a pair for each round: the figures of this side and of that side. Ends with the first run that fails."""
    rounds = []
    for number in range(session.arguments.rounds):
        say(f"{benchmark.name}, round {number + 1} of {session.arguments.rounds}")
        found = {}
        # The sides begin in turns, so that neither gains if the machine becomes slower.
        for tree in (this, that) if number % 2 == 0 else (that, this):
            found[tree] = session.run(tree, benchmark, words, processes.NOWHERE)
            if found[tree] is None:
                return rounds
        rounds.append((found[this], found[that]))
    return rounds


def compare_all(session, this, that):
    """Returns the verdicts on all figures, and (bench, name) of the figures that only this or only that side has."""
    verdicts, only_this, only_that = [], [], []
    names = [benchmark.name for benchmark in session.arguments.benchmarks]
    built = session.build(that, session.build(this, names))
    for benchmark in session.arguments.benchmarks:
        words = session.words_for(benchmark, [this, that]) if benchmark.name in built else None
        if words is None:
            continue
        rounds = measure_both(session, this, that, benchmark, words)
        of_bench, this_names, that_names = comparison.compare(
            benchmark.name, [figures for figures, _ in rounds], [figures for _, figures in rounds])
        verdicts += of_bench
        only_this += [(benchmark.name, name) for name in this_names]
        only_that += [(benchmark.name, name) for name in that_names]
    return verdicts, only_this, only_that


def print_comparison(verdicts, only_this, only_that, this, that):
    print(f"this: {this.title}\nthat: {that.title}")
    for kind in comparison.VERDICTS:
        of_kind = [verdict for verdict in verdicts if verdict.verdict == kind]
        print(f"\n{kind}: {len(of_kind) or 'none'}")
        if of_kind:
            print(f"  {'figure':<48} {'this':>11} {'that':>11} {'unit':<5} {'of':<6} {'change':>9}  99 % interval")
        for verdict in of_kind:
            print(comparison.row(verdict))
    for title, names in (("this", only_this), ("that", only_that)):
        if names:
            print(f"\nonly {title} side has: " + ", ".join(f"{bench} {name}" for bench, name in names))
    judged = sum(verdict.verdict != comparison.UNJUDGED for verdict in verdicts)
    if judged:
        print(f"\nJudged: {judged}. One in about 100 that did not change is called worse or better by chance.")


def as_json(verdicts, only_this, only_that, this, that):
    return {"this": this.title, "that": that.title, "only_this": only_this, "only_that": only_that,
            "figures": [comparison.as_json(verdict) for verdict in verdicts]}


PACKAGES = {"Cyclone DDS": "cyclonedds-dev", "Fast DDS": "libfastrtps-dev", "iceoryx": "libiceoryx-posh-dev",
            "g++": "g++"}


def versions():
    """Returns the versions of the compiler and of the Debian packages with which SFT is compared."""
    done = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\n", *PACKAGES.values()],
                          capture_output=True, text=True, check=False)
    found = dict(line.split(" ", 1) for line in done.stdout.splitlines() if " " in line)
    return ", ".join(f"{name} {found[package]}" for name, package in PACKAGES.items() if found.get(package))


def about_this_machine(root):
    """Returns what the reader of a figure has to know, as texts by their titles."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        models = [line.partition(":")[2].strip() for line in file if line.startswith("model name")]
    model = models[0] if models else platform.machine()
    try:
        commit = trees.git(root, "log", "-1", "--format=%h %s")
    except trees.Refusal:
        commit = "none"  # the sources are no git repository
    return {"commit": commit,
            "processors": f"{os.cpu_count()} x {model}",
            "system": f"{platform.system()} {platform.release()}, {platform.freedesktop_os_release()['PRETTY_NAME']}",
            "versions": versions()}


def check_writable(path):
    if path and not os.access(os.path.dirname(os.path.abspath(path)), os.W_OK):
        raise trees.Refusal(f"cannot write {path}")  # now, instead of after hours of measuring


def check_kept(folder):
    """Refuses a folder with files of another kind, such as the recorded messages that a benchmark reads."""
    check_writable(folder)
    if folder and os.path.isdir(folder) and os.listdir(folder) and \
            not os.path.isfile(os.path.join(folder, records.ABOUT)):
        raise trees.Refusal(f"{folder} has other files than benchmarks keep; name another folder for --keep")


def main(words, root=ROOT):
    arguments = parse(words)
    processes.adopt_orphans()
    session = Session(arguments)
    this = trees.Tree(root, "this tree")
    check_writable(arguments.json)
    check_kept(arguments.keep)
    regressions = []
    if arguments.against is None:
        with tempfile.TemporaryDirectory(prefix="sft_bench_") as folder:
            kept = run_all(session, this, arguments.keep or folder)
        result = kept.figures
    else:
        that = trees.check_out(root, arguments.against)
        verdicts, *only = compare_all(session, this, that)
        print_comparison(verdicts, *only, this, that)
        result = as_json(verdicts, *only, this, that)
        if arguments.fail_above is not None:
            regressions = [one for one in verdicts if one.loss_percent() > arguments.fail_above]
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(result, file, indent=2)
    for one in regressions:
        say(f"run: {one.bench} {one.name} is worse by more than {arguments.fail_above:g} %")
    for problem in session.problems:
        say(f"run: {problem}")
    return 1 if session.problems or regressions else 0


ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def leave(number, _):
    """Ends this process after a signal, so that each `finally` is run. A second Ctrl-C does not interrupt that."""
    for end in ENDS:
        signal.signal(end, signal.SIG_IGN)
    sys.exit(128 + number)


if __name__ == "__main__":
    for end in ENDS:
        signal.signal(end, leave)
    try:
        sys.exit(main(sys.argv[1:]))
    except (trees.Refusal, OSError) as error:
        say(f"run: {error}")
        sys.exit(2)
