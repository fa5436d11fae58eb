"""Compares figures that two builds have measured in the same rounds. Pure functions: they run and read nothing.

In each round both builds measure once, one right after the other, so that a change of the machine's speed affects both.
A round gives one relative change: the logarithm of this build's value divided by that build's. The change of a figure
is the median of its rounds, and its noise is the 99 % interval around it:

- With 8 rounds and more, it is the interval between two of the sorted changes, by the sign test. The test assumes
  nothing about the distribution of the noise. With 12 rounds and more, one disturbed round does not matter.
- With 2 to 7 rounds, even the least and the greatest change are no 99 % interval. So it is that of Student's t, which
  assumes normal noise. It is wide with few rounds: 2.1 standard deviations of a round with 5 rounds, 5.7
  with 3, and 45 with 2.
- One round says nothing about noise, so that nothing is called worse or better.

A figure is worse or better if its interval does not contain "no change". One in about a hundred figures that did not
change is called so by chance. A figure is the same if its interval is narrow, else it is unclear.
"""

import math
import statistics
from dataclasses import dataclass

LOWER, HIGHER = "lower", "higher"

# Says for each unit of the benchmarks which values are better. A figure with another unit is not judged, and the
# comparison says why.
UNITS = {
    "ns": LOWER,
    "us": LOWER,
    "ms": LOWER,
    "s": LOWER,
    "s/GB": LOWER,  # processor time
    "B": LOWER,
    "MB": LOWER,
    "B/s": LOWER,  # traffic that carries no samples
    "/s": LOWER,  # datagrams that carry no samples
    "%": LOWER,  # overhead, processor time
    "": LOWER,  # lost samples, allocations, lines of code
    "GB/s": HIGHER,
    "k/s": HIGHER,  # thousands of samples
}

UNITS_NOT_JUDGED = {"exponent": "it follows from the figures of four sizes, which are judged"}

# Figures about the machine, which do not depend on SFT.
NOISE = ("noise_other_programs", "noise_other_machines")

WORSE, BETTER, SAME, UNCLEAR, UNJUDGED = "worse", "better", "same", "unclear, since the noise is large", "not judged"
VERDICTS = (WORSE, BETTER, SAME, UNCLEAR, UNJUDGED)
SAME_MAX = 0.1  # a figure is the same if the ends of its interval are within this change

# Two-sided 99 % quantiles of Student's t for 1 to 6 degrees of freedom.
STUDENT = [63.657, 9.925, 5.841, 4.604, 4.032, 3.707]
SIGN_TEST_ROUNDS_MIN = len(STUDENT) + 2
ERROR = 0.01


@dataclass
class Change:
    """A relative change: 0.1 means 10 % more. Infinite for a change from zero, which has no relative size."""

    middle: float
    low: float
    high: float

    def differs(self):
        return self.low > 0 or self.high < 0

    def width(self):
        return self.high - self.low


@dataclass
class Verdict:
    bench: str
    name: str
    unit: str
    verdict: str
    used: str  # what was judged: "value" or "ratio"
    changes: dict  # the changes of the value, of the ratio and of the reference
    notes: list
    this: list  # the judged number of each round
    that: list

    def change(self):
        return self.changes[self.used]

    def loss_percent(self):
        """Returns by how many percent the figure is worse; 0 if it is not clearly worse."""
        return 100 * abs(self.change().middle) if self.verdict == WORSE else 0.0


def sign_test_rank(rounds):
    """Returns the rank k. In 99 % of cases, the median is between the k-th smallest and the k-th largest value."""
    below, rank = 0.0, 0
    while True:
        below += math.comb(rounds, rank) / 2**rounds
        if 2 * below > ERROR:
            return rank
        rank += 1


def interval(numbers):
    """Returns the lower and the upper end of the 99 % interval of the middle of at least two numbers."""
    rounds = len(numbers)
    if rounds >= SIGN_TEST_ROUNDS_MIN:
        rank = sign_test_rank(rounds)
        in_order = sorted(numbers)
        return in_order[rank - 1], in_order[-rank]
    mean = statistics.fmean(numbers)
    half = STUDENT[rounds - 2] * statistics.stdev(numbers) / math.sqrt(rounds)
    return mean - half, mean + half


def change_of(this, that):
    """Returns the change from `that` to `this`, whose n-th values are of one round. None for fewer than two rounds."""
    if len(this) < 2:
        return None
    if min(this + that) > 0:
        steps = [math.log(a / b) for a, b in zip(this, that)]
        numbers = (statistics.median(steps), *interval(steps))
        return Change(*(math.expm1(min(number, 700.0)) for number in numbers))
    # Zero and negative values, such as lost samples and differences of times, have no ratio.
    steps = [a - b for a, b in zip(this, that)]
    numbers = (statistics.median(steps), *interval(steps))
    base = abs(statistics.median(that))
    return Change(*(number / base if base else math.copysign(math.inf, number) if number else 0.0
                    for number in numbers))


def rounds_of(this, that, key):
    """Returns the numbers `key` of both sides, for the rounds in which both have one."""
    pairs = [(a[key], b[key]) for a, b in zip(this, that)
             if a is not None and b is not None and is_number(a.get(key)) and is_number(b.get(key))]
    return [a for a, _ in pairs], [b for _, b in pairs]


def is_number(value):
    return isinstance(value, (int, float)) and math.isfinite(value)


def value_or_ratio(by_value, by_ratio, of_reference):
    """Returns if the value or the ratio to the reference is judged, and notes about that for the reader.

    The ratio is judged if its noise is less and the reference is the same on both sides. If the reference differs,
    as it may if the reference is SFT itself, the ratio would hide a change of both.
    """
    if by_value is None or by_ratio is None or of_reference is None:
        return "value", []
    used, other = ("ratio", by_value) if by_ratio.width() < by_value.width() else ("value", by_ratio)
    notes = []
    if of_reference.differs():
        used, other = "value", by_ratio
        notes.append(f"the reference changed by {percent(of_reference.middle)}")
    change = by_ratio if used == "ratio" else by_value
    if other.differs() and not (change.differs() and (change.middle > 0) == (other.middle > 0)):
        notes.append(f"the {'value' if used == 'ratio' else 'ratio'} changed by {percent(other.middle)}")
    return used, notes


def gaps(this, that):
    """Returns notes about a side that has rounds without a value."""
    notes = []
    for side, rounds in (("this", this), ("that", that)):
        missing = sum(entry is None or not is_number(entry["value"]) for entry in rounds)
        if missing:
            notes.append(f"{side} side has no value in {missing} of {len(rounds)} rounds")
    return notes


def judge(bench, name, this, that):
    """Returns the verdict on one figure. The lists have for each round its entry in the output of --json, or None."""
    units = list(dict.fromkeys(entry["unit"] for entry in this + that if entry is not None))
    changes = {key: change_of(*rounds_of(this, that, key)) for key in ("value", "ratio", "reference")}
    used, notes = value_or_ratio(*changes.values())
    change = changes[used]
    verdict = Verdict(bench, name, units[0], UNJUDGED, used, changes, gaps(this, that) + notes,
                      *rounds_of(this, that, used))
    if len(units) > 1:
        verdict.notes.append(f"it has several units: {', '.join(units)}")
    elif units[0] not in UNITS:
        unknown = f"the unit '{units[0]}' is unknown to the table in bench/comparison.py"
        verdict.notes.append(UNITS_NOT_JUDGED.get(units[0], unknown))
    elif change is None:
        verdict.notes.append(f"rounds with a value on both sides: {len(verdict.this)}; noise needs two")
    elif not change.differs():
        verdict.verdict = SAME if -SAME_MAX <= change.low and change.high <= SAME_MAX else UNCLEAR
    else:
        verdict.verdict = WORSE if (change.middle > 0) == (UNITS[units[0]] == LOWER) else BETTER
    return verdict


def compare(bench, this, that):
    """Returns verdicts on all figures of a benchmark, and the names that only this or only that side has.

    `this` and `that` have one list of figures for each round.
    """
    this_rounds, that_rounds = ([{figure["name"]: figure for figure in figures if figure["name"] not in NOISE}
                                 for figures in side] for side in (this, that))
    this_names = list(dict.fromkeys(name for figures in this_rounds for name in figures))
    that_names = list(dict.fromkeys(name for figures in that_rounds for name in figures))
    verdicts = [judge(bench, name, [figures.get(name) for figures in this_rounds],
                      [figures.get(name) for figures in that_rounds])
                for name in this_names if name in that_names]
    return (verdicts, [name for name in this_names if name not in that_names],
            [name for name in that_names if name not in this_names])


def percent(change):
    if not math.isfinite(change):
        return "from 0" if change > 0 else "below 0"
    return f"{100 * change:+.1f} %" if change < 100 else "> 9999 %"


def row(verdict):
    """Returns a line of the table."""
    this, that = (f"{statistics.median(side):.4g}" if side else "" for side in (verdict.this, verdict.that))
    change = verdict.change()
    words = f"{percent(change.middle):>9}  {percent(change.low)} to {percent(change.high)}" if change else ""
    notes = f"  ({'; '.join(verdict.notes)})" if verdict.notes else ""
    unit = verdict.unit if verdict.used == "value" else ""
    return (f"  {verdict.bench + ' ' + verdict.name:<48} {this:>11} {that:>11} {unit:<5} {verdict.used:<6} "
            f"{words}{notes}").rstrip()


def as_json(verdict):
    def in_percent(change):
        return change and {key: 100 * number if math.isfinite(number) else None for key, number in vars(change).items()}

    return {"bench": verdict.bench, "name": verdict.name, "unit": verdict.unit, "verdict": verdict.verdict,
            "used": verdict.used, "notes": verdict.notes, "this": verdict.this, "that": verdict.that,
            "changes_percent": {key: in_percent(change) for key, change in verdict.changes.items()}}
