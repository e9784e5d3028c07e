"""Rules, local transfers and QR against one another on many random robots and on a grid of small ones.

    python benchmarks/base_parameters.py [--robots 20000] [--processes 2]

Prints every disagreement, how often each rule was met, and the gap between what QR rejects and accepts. Exit
status 1 if anything disagrees.
"""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from multiprocessing import Pool

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")  # small matrices: one thread a process is fastest

from dynident.tests.model.random_robots import random_robot, small_robots  # noqa: E402
from dynident.tests.model.three_ways import Comparison, compare  # noqa: E402

GROUPING, MODEL, GAP, RULE = 1e-6, 1e-10, 1e6, 1000
"""What is asked: groupings, W = W_base G, accepted over rejected residual, times each rule is met."""

SMALL = list(small_robots())


def compare_random(seed: int) -> Comparison:
    return compare(random_robot(seed))


def compare_weightless(seed: int) -> Comparison:
    return compare(replace(random_robot(seed), gravity=(0.0, 0.0, 0.0)))


def compare_small(index: int) -> Comparison:
    return compare(SMALL[index])


def report(title: str, comparisons: Iterable[Comparison]) -> tuple[bool, Counter[str]]:
    """Print what a set of robots came to; whether all is as asked, and the rules met."""
    start, rules = time.perf_counter(), Counter[str]()
    results = list(comparisons)
    bad = [
        k
        for k, comparison in enumerate(results)
        if not (comparison.names and comparison.grouping < GROUPING and comparison.model < MODEL)
    ]
    for comparison in results:
        rules += comparison.rules
    rejected, accepted = (
        max(comparison.rejected for comparison in results),
        min(comparison.accepted for comparison in results),
    )
    print(f"{title}: {len(results)} robots in {time.perf_counter() - start:.0f} s, {len(bad)} disagree {bad[:20]}")
    print(f"  largest difference of groupings     {max(comparison.grouping for comparison in results):.1e}")
    print(f"  largest ||W - W_base G|| / ||W||    {max(comparison.model for comparison in results):.1e}")
    print(f"  QR: largest rejected residual {rejected:.1e}, smallest accepted {accepted:.1e}")
    return not bad and accepted > GAP * rejected, rules


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=20000)
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    with Pool(arguments.processes) as pool:
        random, rules = report("random", pool.imap(compare_random, range(arguments.robots), chunksize=50))
        weightless, _ = report(
            "without gravity (no rules)", pool.imap(compare_weightless, range(arguments.robots // 10), chunksize=50)
        )
        small, _ = report("one and two joints", pool.imap(compare_small, range(len(SMALL)), chunksize=50))
    for rule, count in sorted(rules.items()):
        print(f"{count:8d}  {rule}")
    met = min(rules.values()) >= RULE or arguments.robots < 20000
    return 0 if random and weightless and small and met else 1


if __name__ == "__main__":
    sys.exit(main())
