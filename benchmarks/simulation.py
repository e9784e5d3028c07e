"""The paper's 38 runs in closed loop: processor time, and what identification loses without any noise.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/simulation.py

Time is the processor's, of one thread, code compiled before. Without noise the recordings are exact; what method 4
then misses comes from its filter and from dry friction that is smooth about rest.
"""

import time

import numpy as np
from dynident.apps.commands.demo import levels, paper_robot, reduced_experiment, simulate_paper
from dynident.estimation import PAYLOAD
from dynident.examples.paper.analysis import robust_joint, true_values
from dynident.examples.paper.printed import paper_tables


def main() -> None:
    robot, paper = paper_robot(), paper_tables()
    simulate_paper(robot, levels("none"), 0, 1)  # compiles
    start = time.process_time()
    experiment = simulate_paper(robot, levels("none"), 0)
    seconds = time.process_time() - start
    duration = sum(run.exact.motion.t[-1] for run in experiment.runs)
    print(f"{len(experiment.runs)} runs, {duration:.0f} s of motion: {seconds:.1f} s of processor time")
    problem = reduced_experiment(experiment)
    truth, joint = true_values(experiment, problem), robust_joint(problem)
    print("Largest errors without noise, method 4:")
    for names in (tuple(paper.table2_robot), tuple(f"{kind}_L" for kind in ("XX", "YY", "ZZ", "MZ", "M"))):
        errors = [(abs(joint[name] - truth[name]), name) for name in names if truth[name]]
        relative = sorted(((error / abs(truth[name]), name) for error, name in errors), reverse=True)[:5]
        print("  " + ", ".join(f"{name} {100 * share:.2f} %" for share, name in relative))
    off = np.abs([joint[name] - truth[name] for name in PAYLOAD])
    print("  payload: " + ", ".join(f"{name} {error:.1e}" for name, error in zip(PAYLOAD, off, strict=True)))


if __name__ == "__main__":
    main()
