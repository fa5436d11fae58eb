"""The benchmarks of ./run bench all, in their order."""

from dataclasses import dataclass


@dataclass
class Benchmark:
    name: str
    seconds: int  # that it takes with its own defaults, on two cores
    quick_seconds: int
    quick: list  # arguments of a short run

    def limit_s(self, quick):
        """A run that takes longer hangs."""
        return 60 + 4 * (self.quick_seconds if quick else self.seconds)


ALL = [
    Benchmark("micro", 50, 10, ["--quick"]),
    Benchmark("typesupport", 70, 25, ["--rounds", "50"]),
    Benchmark("selection", 50, 20, ["--rounds", "20", "--host-rounds", "1"]),
    Benchmark("spine", 110, 50, ["--rounds", "1"]),
    Benchmark("shm", 80, 10, ["--rounds", "1", "--idle-seconds", "2"]),
    Benchmark("negotiation", 90, 15, ["--rounds", "1"]),
    Benchmark("udp", 380, 150, ["--rounds", "1", "--messages", "500", "--seconds", "0.3"]),
    Benchmark("many", 1780, 230, ["--quick"]),
    Benchmark("paper", 1500, 80, ["--quick"]),
    Benchmark("peers", 660, 60, ["--quick"]),
    Benchmark("isolation", 540, 65, ["--quick"]),
    Benchmark("recovery", 140, 50, ["--rounds", "1"]),
]

# What benchmarks write beside their figures, for plots: the option and the file that it names.
FILES = {"peers": ("--csv", "peers.csv"), "paper": ("--trace", "trace.csv")}
ROUNDS = 5
QUICK_ROUNDS = 3  # of less than thirteen minutes on each side
