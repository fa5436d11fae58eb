#!/usr/bin/env python3
"""failures.py REPORT: prints the failures of a run of ctest. REPORT is the file that ctest --output-junit writes.

Each failed test is printed with the seed of its random numbers, a command that repeats it, and the end of its log.
"""

import re
import sys
import xml.etree.ElementTree as xml

LINES = 40  # the number of lines to print of each log


def seed_of(log):
    """Returns the last seed in the log, which belongs to the failure. The program may have begun with another seed."""
    seeds = re.findall(r"SFT_TEST_SEED=(\d+)", log)
    return seeds[-1] if seeds else None


def failed_cases(report):
    return [case for case in xml.parse(report).getroot().iter("testcase") if case.get("status") == "fail"]


def without_passed(lines):
    """Returns the log of a suite without the output of tests that passed."""
    kept, of_this_test = [], []
    for line in lines:
        if line.startswith("[ RUN "):
            kept += of_this_test
            of_this_test = [line]
        elif line.startswith("[       OK "):
            of_this_test = []
        elif of_this_test:
            of_this_test.append(line)
        else:
            kept.append(line)
    return kept + of_this_test


def describe(case):
    name = case.get("name")
    failure = case.find("failure")
    reason = (failure.get("message") if failure is not None else "") or "Failed"
    log = (case.findtext("system-out") or "").strip("\n")
    seed = seed_of(log)
    again = (f"SFT_TEST_SEED={seed} " if seed else "") + f"./run test '^{re.escape(name)}$'"
    lines = without_passed(log.splitlines())
    end = "\n".join(f"    {line}" for line in lines[-LINES:])
    cut = f"    ... {len(lines) - LINES} lines before these\n" if len(lines) > LINES else ""
    return f"== {name}: {reason} after {float(case.get('time', 0)):.1f} s; to repeat: {again}\n{cut}{end}\n"


def main():
    cases = failed_cases(sys.argv[1])
    for case in cases:
        print(describe(case))
    print(f"{len(cases)} tests failed:" if len(cases) != 1 else "1 test failed:")
    for case in cases:
        print(f"  {case.get('name')}")


if __name__ == "__main__":
    main()
