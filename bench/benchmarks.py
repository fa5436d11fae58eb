"""The benchmarks of ./run bench all, in their order. As a program, prints how long the one of its argument takes."""

import sys
from dataclasses import dataclass


@dataclass
class Benchmark:
    name: str
    seconds: int  # duration with default arguments, on two cores
    quick_seconds: int
    quick: list  # arguments for a short run

    def limit_s(self, quick):
        """Returns the seconds after which a run is considered to hang."""
        return 60 + 4 * (self.quick_seconds if quick else self.seconds)


ALL = [
    Benchmark("typesupport", 10, 5, ["--rounds", "50"]),
    Benchmark("selection", 120, 45, ["--rounds", "20", "--host-rounds", "1"]),
    Benchmark("shm", 80, 10, ["--rounds", "1"]),
    Benchmark("negotiation", 90, 15, ["--rounds", "1"]),
    Benchmark("tools", 120, 45, ["--rounds", "1", "--seconds", "1"]),
    Benchmark("udp", 240, 100, ["--rounds", "1", "--messages", "500", "--seconds", "0.3"]),
    Benchmark("vanilla", 210, 75, ["--rounds", "1", "--samples", "30", "--starts", "5", "--idle-seconds", "5"]),
    Benchmark("many", 1200, 100, ["--quick"]),
    Benchmark("paper", 1500, 80, ["--quick"]),
    Benchmark("peers", 660, 60, ["--quick"]),
    Benchmark("bridge", 100, 35, ["--rounds", "1", "--seconds", "4"]),
    Benchmark("isolation", 540, 65, ["--quick"]),
    Benchmark("recovery", 140, 50, ["--rounds", "1"]),
]

# Files for plots that benchmarks write in addition to their figures: the option, and the name of the file that it gets.
FILES = {"peers": ("--csv", "peers.csv")}
ROUNDS = 5
QUICK_ROUNDS = 3  # a round takes less than thirteen minutes on each side


if __name__ == "__main__":
    for benchmark in ALL:
        if [benchmark.name] == sys.argv[1:]:
            print(f"{benchmark.name} takes about {benchmark.seconds} s on two cores if it is given no arguments")
