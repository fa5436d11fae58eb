#!/usr/bin/env python3
"""Tests of ./run bench all: the statistics, and whole comparisons with scripts instead of benchmarks."""

import contextlib
import io
import json
import os
import random
import signal
import stat
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bench"))

import all as bench_all
import benchmarks
import comparison
import processes
import trees

SEED = int(os.environ.get("SFT_TEST_SEED", "1"))


def figure(value, unit="us", reference=None, name="figure"):
    return {"name": name, "value": value, "unit": unit, "reference": reference,
            "ratio": None if reference is None or value is None else value / reference}


def judged(this, that, unit="us"):
    return comparison.judge("bench", "figure", [figure(value, unit) for value in this],
                            [figure(value, unit) for value in that])


class VerdictTest(unittest.TestCase):
    def test_a_longer_time_beyond_the_noise_is_worse_and_a_shorter_one_better(self):
        self.assertEqual(judged([20.1, 20.0, 20.2], [10.0, 10.1, 10.0]).verdict, comparison.WORSE)
        self.assertEqual(judged([10.0, 10.1, 10.0], [20.1, 20.0, 20.2]).verdict, comparison.BETTER)

    def test_a_higher_throughput_is_better(self):
        self.assertEqual(judged([2.01, 2.0, 2.02], [1.0, 1.01, 1.0], "GB/s").verdict, comparison.BETTER)

    def test_a_change_within_little_noise_is_none_and_within_much_noise_unclear(self):
        self.assertEqual(judged([10, 10.2, 10.1], [10.1, 10.1, 10.1]).verdict, comparison.SAME)
        self.assertEqual(judged([10, 14, 11], [11, 12, 13]).verdict, comparison.UNCLEAR)

    def test_a_drift_that_meets_both_sides_of_a_round_does_not_hide_a_change(self):
        self.assertEqual(judged([11.0, 22.1, 44.0], [10.0, 20.0, 40.1]).verdict, comparison.WORSE)

    def test_the_change_is_the_median_of_the_rounds(self):
        change = judged([11, 12, 30, 11, 11], [10] * 5).change()
        self.assertAlmostEqual(change.middle, 0.1)

    def test_one_round_is_not_judged(self):
        verdict = judged([20], [10])
        self.assertEqual(verdict.verdict, comparison.UNJUDGED)
        self.assertIn("noise needs two", comparison.row(verdict))

    def test_an_unknown_unit_is_not_judged_but_named(self):
        verdict = judged([20, 20, 20], [10, 10, 10], "furlongs")
        self.assertEqual(verdict.verdict, comparison.UNJUDGED)
        self.assertIn("furlongs", comparison.row(verdict))

    def test_an_exponent_is_not_judged_since_its_figures_are(self):
        verdict = judged([2, 2, 2], [1, 1, 1], "exponent")
        self.assertEqual(verdict.verdict, comparison.UNJUDGED)
        self.assertIn("which are judged", verdict.notes[-1])

    def test_rounds_without_a_value_do_not_count(self):
        verdict = judged([None, 20, 20], [10, 10, None])
        self.assertEqual(verdict.verdict, comparison.UNJUDGED)
        self.assertEqual(verdict.this, [20])
        self.assertIn("this side has no value in 1 of 3 rounds", comparison.row(verdict))

    def test_losses_where_none_were_are_worse(self):
        verdict = judged([3, 3, 3], [0, 0, 0], "")
        self.assertEqual(verdict.verdict, comparison.WORSE)
        self.assertIn("from 0", comparison.row(verdict))
        self.assertEqual(judged([0, 0, 0], [0, 0, 0], "").verdict, comparison.SAME)

    def test_the_noise_of_the_machine_is_no_figure_of_a_benchmark(self):
        sides = [[figure(1), *(figure(value, "%", name=name) for name in comparison.NOISE)] for value in (1, 2, 3)]
        verdicts, only_this, only_that = comparison.compare("bench", sides, [one[:1] for one in sides])
        self.assertEqual([verdict.name for verdict in verdicts], ["figure"])
        self.assertEqual((only_this, only_that), ([], []))

    def test_a_figure_of_one_side_is_listed(self):
        this = [[figure(1, name="old"), figure(1, name="new")]] * 2
        verdicts, only_this, only_that = comparison.compare(
            "bench", this, [[figure(1, name="old"), figure(1, name="gone")]] * 2)
        self.assertEqual([verdict.name for verdict in verdicts], ["old"])
        self.assertEqual((only_this, only_that), (["new"], ["gone"]))


class ReferenceTest(unittest.TestCase):
    def judge(self, this, that):
        return comparison.judge("bench", "figure", [figure(*one) for one in this], [figure(*one) for one in that])

    def test_the_ratio_is_judged_where_it_has_less_noise(self):
        verdict = self.judge([(11, "us", 10), (22, "us", 20), (5.55, "us", 5)],
                             [(20, "us", 20), (5, "us", 5), (10, "us", 10)])
        self.assertEqual((verdict.used, verdict.verdict), ("ratio", comparison.WORSE))

    def test_the_value_is_judged_where_it_has_less_noise(self):
        verdict = self.judge([(11, "us", 3), (11.1, "us", 9), (11, "us", 5)],
                             [(10, "us", 9), (10, "us", 3), (10.1, "us", 5)])
        self.assertEqual((verdict.used, verdict.verdict), ("value", comparison.WORSE))

    def test_a_reference_that_changed_with_the_figure_hides_nothing(self):
        verdict = self.judge([(20.5, "us", 10.25), (24, "us", 12), (22, "us", 11)],
                             [(10, "us", 5), (12, "us", 6), (11, "us", 5.5)])
        self.assertEqual((verdict.used, verdict.verdict), ("value", comparison.WORSE))
        self.assertIn("the reference changed by +100.0 %", comparison.row(verdict))


    def test_a_change_of_what_is_not_judged_is_told(self):
        verdict = self.judge([(10, "us", 5), (10, "us", 5), (10.1, "us", 5)],
                             [(10, "us", 10), (10, "us", 10), (10, "us", 10)])
        self.assertEqual((verdict.used, verdict.verdict), ("value", comparison.SAME))
        self.assertIn("the ratio changed by +100.0 %", comparison.row(verdict))


class NoiseTest(unittest.TestCase):
    def false_alarms(self, rounds, spread, times=3000):
        numbers = random.Random(SEED)
        found = 0
        for _ in range(times):
            this, that = ([10 * spread(numbers) for _ in range(rounds)] for _ in range(2))
            found += comparison.change_of(this, that).differs()
        return found / times

    def test_at_most_about_one_of_a_hundred_unchanged_figures_differs(self):
        for rounds in (2, 3, 4, 5, 6, 7, 8, 12):
            with self.subTest(rounds=rounds):
                self.assertLess(self.false_alarms(rounds, lambda numbers: numbers.lognormvariate(0, 0.05)), 0.016)

    def test_rounds_that_something_disturbs_cause_no_more_of_them(self):
        def spread(numbers):
            return numbers.lognormvariate(0, 0.02) * (3 if numbers.random() < 0.1 else 1)

        for rounds in (5, 8):
            with self.subTest(rounds=rounds):
                self.assertLess(self.false_alarms(rounds, spread), 0.016)

    def test_one_disturbed_round_of_twelve_does_not_hide_a_change(self):
        self.assertEqual(judged([11] * 11 + [2], [10] * 12).verdict, comparison.WORSE)


BENCH = """#!/bin/bash
[[ $1 != --help ]] || {{ echo '  --json TEXT    file'; echo '  --rounds INT:INT in [1 - 9]'
echo '  --only TEXT:{{bulk,small,rate}} ...    these groups'; exit; }}
echo "{side} $*" >>"{log}"
{act}
"""
WRITES = """echo '[{{"name": "time", "value": {value}, "unit": "us", "reference": null, "ratio": null}}]' >"$2" """


class ComparisonTest(unittest.TestCase):
    """Each test has a repository whose ./run copies the scripts of bench/NAME/main.cpp."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = os.path.join(os.path.realpath(folder.name), "tree")
        self.log = os.path.join(folder.name, "log")
        self.json = os.path.join(folder.name, "json")
        os.mkdir(self.root)
        self.git("init", "-q")
        self.write("run", """#!/bin/bash
cd -- "$(dirname -- "$0")" && mkdir -p build/release/bin
for target in "${@:2}"; do
  [[ $target == sftd ]] || cp "bench/${target#bench_}/main.cpp" "build/release/bin/$target" || exit 1
done
""")
        self.write(".gitignore", "/build/\n")

    def git(self, *arguments):
        return subprocess.run(["git", "-C", self.root, "-c", "user.name=a", "-c", "user.email=b", *arguments],
                              check=True, capture_output=True, text=True).stdout

    def write(self, path, text):
        full = os.path.join(self.root, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(full, os.stat(full).st_mode | stat.S_IXUSR)

    def bench(self, side, name, act):
        self.write(f"bench/{name}/main.cpp", BENCH.format(side=side, log=self.log, act=act))

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "A commit")

    def both(self, that, this, name="udp"):
        self.bench("that", name, that)
        self.commit()
        self.bench("this", name, this)

    def run_all(self, *words):
        """Runs it and returns the exit code. The output is in self.out."""
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            code = bench_all.main(["--json", self.json, *words], self.root)
        self.out = output.getvalue()
        return code

    def verdicts(self):
        with open(self.json, encoding="utf-8") as file:
            return {one["bench"]: one["verdict"] for one in json.load(file)["figures"]}

    def runs(self):
        with open(self.log, encoding="utf-8") as file:
            return [line.split()[0] for line in file]

    def test_a_slower_benchmark_is_worse_and_both_sides_run_in_turns(self):
        self.both(WRITES.format(value=10), WRITES.format(value=20))
        self.assertEqual(self.run_all("--against", "HEAD", "--only", "udp", "--rounds", "3"), 0)
        self.assertEqual(self.verdicts(), {"udp": "worse"})
        self.assertEqual(self.runs(), ["this", "that", "that", "this", "this", "that"])

    def test_only_a_regression_above_the_limit_is_a_failure(self):
        self.both(WRITES.format(value=10), WRITES.format(value=11))
        words = ("--against", "HEAD", "--only", "udp", "--rounds", "2", "--fail-above")
        self.assertEqual(self.run_all(*words, "5"), 1)
        self.assertEqual(self.run_all(*words, "15"), 0)

    def test_a_benchmark_that_hangs_or_fails_is_named_and_the_others_run(self):
        self.bench("that", "recovery", "sleep 1000")
        self.bench("that", "shm", "exit 3")
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        for name in ("recovery", "shm"):
            self.bench("this", name, WRITES.format(value=1))
        code = self.run_all("--against", "HEAD", "--only", "recovery,shm,udp", "--rounds", "2", "--time-limit", "1")
        self.assertEqual(code, 1)
        self.assertRegex(self.out, "bench_recovery of .* does not end within 1")
        self.assertRegex(self.out, "bench_shm of .* fails with exit code 3")
        self.assertEqual(self.verdicts(), {"udp": "same"})

    def test_a_benchmark_that_does_not_build_is_named_and_the_others_run(self):
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        self.bench("this", "shm", WRITES.format(value=1))
        self.git("stash", "-q", "-u")
        self.write("bench/shm/main.cpp", "")
        self.write("run", """#!/bin/bash
[[ $* != *bench_shm* ]] && cd -- "$(dirname -- "$0")" && mkdir -p build/release/bin &&
  cp bench/udp/main.cpp build/release/bin/bench_udp
""")
        self.commit()
        broken = self.git("rev-parse", "HEAD").strip()
        self.git("reset", "-q", "--hard", "HEAD~1")
        self.git("stash", "pop", "-q")
        self.assertEqual(self.run_all("--against", broken, "--only", "shm,udp", "--rounds", "2"), 1)
        self.assertRegex(self.out, "bench_shm of .* does not build")
        self.assertEqual(self.verdicts(), {"udp": "same"})

    def test_arguments_that_a_side_lacks_are_left_out(self):
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        code = self.run_all("--against", "HEAD", "--only", "udp", "--rounds", "2", "--", "--rounds", "7", "--seconds=1")
        self.assertEqual(code, 0)
        self.assertIn("runs without --seconds", self.out)
        with open(self.log, encoding="utf-8") as file:
            self.assertTrue(all(line.endswith(" --rounds 7\n") for line in file))

    def test_an_argument_may_be_several_of_the_values_that_an_option_takes(self):
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        words = ("--against", "HEAD", "--only", "udp", "--rounds", "2", "--", "--only")
        self.assertEqual(self.run_all(*words, "bulk,rate"), 0)
        self.assertEqual(self.verdicts(), {"udp": "same"})
        self.assertEqual(self.run_all(*words, "bulk,row"), 0)
        self.assertIn("--only takes no 'bulk,row'", self.out)

    def test_git_forgets_a_worktree_whose_folder_was_deleted(self):
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        path = trees.check_out(self.root, "HEAD").root
        self.assertIn(path, self.git("worktree", "list"))
        subprocess.run(["rm", "-r", path], check=True)
        trees.forget_deleted(self.root, os.path.dirname(path))
        self.assertNotIn(path, self.git("worktree", "list"))

    def test_a_checkout_that_was_changed_is_refused(self):
        self.both(WRITES.format(value=10), WRITES.format(value=10))
        path = trees.check_out(self.root, "HEAD").root
        with open(os.path.join(path, "run"), "a", encoding="utf-8") as file:
            file.write("# changed")
        with self.assertRaises(trees.Refusal):
            trees.check_out(self.root, "HEAD")

    def test_a_commit_that_is_not_there_is_refused(self):
        with self.assertRaisesRegex(trees.Refusal, "there is no commit 'nowhere'"):
            trees.check_out(self.root, "nowhere")

    def test_without_a_commit_all_run_once(self):
        self.bench("this", "udp", WRITES.format(value=10))
        self.assertEqual(self.run_all("--only", "udp"), 0)
        self.assertEqual(self.runs(), ["this"])
        with open(self.json, encoding="utf-8") as file:
            self.assertEqual(json.load(file)["udp"][0]["value"], 10)

    def test_what_plots_show_is_kept_beside_that_of_earlier_runs(self):
        self.bench("this", "udp", WRITES.format(value=10))
        self.write("bench/peers/main.cpp", """#!/bin/bash
[[ $1 != --help ]] || { echo '  --json TEXT   file'; echo '  --csv TEXT   file'; exit; }
echo '[]' >"$2"
[[ $3 == --csv ]] && echo bytes,p50_us >"$4"
""")
        data = os.path.join(self.root, "data")
        self.assertEqual(self.run_all("--only", "udp", "--keep", data), 0)
        self.assertEqual(self.run_all("--only", "peers", "--keep", data), 0)
        self.assertEqual(sorted(os.listdir(data)), ["about.json", "peers.csv", "peers.json", "udp.json"])
        with open(os.path.join(data, "about.json"), encoding="utf-8") as file:
            about = json.load(file)
        self.assertEqual(about["peers"]["command"], "./run bench peers")  # without the file that it wrote
        own = os.path.join(self.root, "own.csv")
        self.assertEqual(self.run_all("--only", "peers", "--", "--csv", own), 0)
        self.assertTrue(os.path.isfile(own))
        self.assertRegex(about["udp"]["date"], r"^\d{4}-\d\d-\d\d$")

    def test_nothing_is_kept_among_files_of_another_kind(self):
        self.bench("this", "udp", WRITES.format(value=10))
        sources = os.path.join(self.root, "bench")
        before = sorted(os.listdir(sources))
        with self.assertRaisesRegex(trees.Refusal, "has other files than benchmarks keep"):
            self.run_all("--only", "udp", "--keep", sources)
        self.assertEqual(sorted(os.listdir(sources)), before)


class ProcessesTest(unittest.TestCase):
    def test_a_program_that_ends_leaves_no_daemon(self):
        with tempfile.NamedTemporaryFile("r") as file:
            self.assertEqual(processes.run(["bash", "-c", f"setsid sleep 10 & echo $! >{file.name}; exit 4"]), 4)
            self.assertFalse(os.path.exists(f"/proc/{file.read().strip()}"))

    def test_an_interrupt_ends_all_processes(self):
        def interrupt(*_):
            raise KeyboardInterrupt

        before = signal.signal(signal.SIGUSR1, interrupt)
        self.addCleanup(signal.signal, signal.SIGUSR1, before)
        with self.assertRaises(KeyboardInterrupt):
            processes.run(["bash", "-c", f"trap '' TERM; setsid sleep 1000 & kill -USR1 {os.getpid()}; wait"])
        self.assertEqual(processes.descendants(os.getpid()), [])


class TableTest(unittest.TestCase):
    def test_each_benchmark_of_the_tree_is_in_the_table(self):
        folders = {name for name in os.listdir(os.path.join(ROOT, "bench"))
                   if os.path.isfile(os.path.join(ROOT, "bench", name, "main.cpp"))}
        self.assertEqual({benchmark.name for benchmark in benchmarks.ALL}, folders)


if __name__ == "__main__":
    print(f"to repeat: SFT_TEST_SEED={SEED}", flush=True)
    processes.adopt_orphans()
    unittest.main()
