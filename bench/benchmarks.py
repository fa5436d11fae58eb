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
    Benchmark("typesupport", 60, 30, ["--rounds", "50"]),
    Benchmark("spine", 60, 50, ["--rounds", "1"]),
    Benchmark("shm", 60, 15, ["--rounds", "1", "--idle-seconds", "2"]),
    Benchmark("negotiation", 60, 20, ["--rounds", "1"]),
    Benchmark("udp", 240, 60, ["--rounds", "1", "--messages", "500", "--seconds", "0.3"]),
    Benchmark("recovery", 180, 60, ["--rounds", "1"]),
]
ROUNDS = 5
QUICK_ROUNDS = 3
