"""The paper's experiment on a simulated RX90, from trajectories to the tables."""

from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from ..estimation import (
    Identification,
    Observer,
    PayloadAnswer,
    answer_payload,
    combined,
    fit,
    identify,
    loaded_problem,
    measurement,
    payload_problem,
)
from ..estimation.payload import payload_map
from ..model import Recording, Robot, load_robot
from ..report.documents import payload_document, write_json
from ..report.paper import PaperTables, paper_tables
from ..report.plots import save_torques
from ..report.tables import console, paper_payload_table, paper_robot_table, payload_notes
from ..trajectories import RX90_NOISE, Simulator, random_via_points

RATE = 250.0
"""Hz, as the paper's controller records."""
VIA_POINTS = 14
"""Points per trajectory, as in the paper."""


def run_demo(folder: Path, seed: int, trajectories: int) -> int:
    """Simulate, identify by all four methods, and print the result next to the truth and the paper.

    Args:
        folder: where the figure and the JSON go; made if it is not there.
        seed: of the trajectories and the noise.
        trajectories: number of trajectories, each run without and with payload; one more is held out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    robot, paper = load_robot("rx90"), paper_tables()
    unloaded, loaded = record_runs(robot, paper, seed, trajectories + 1)
    with Console(stderr=True).status("reducing") as status:
        robot_result = identify(robot, unloaded[:-1], progress=status.update)
        problem = payload_problem(robot, loaded[:-1], unloaded[:-1], progress=status.update)
        answer = answer_payload(problem, held_out=unloaded[-1:])
    tables = _tables(robot_result, answer, paper)
    terminal = console(*tables)
    terminal.print(*tables)
    held_out = loaded_problem(robot, problem.base, [measurement(loaded[-1], robot.processing)], robot.processing)
    both = fit(held_out, combined(problem).values)
    terminal.print(f"Held-out trajectory with payload: relative residual {100 * both.relative:.2f} % (method 4).")
    for line in payload_notes(answer):
        terminal.print(line, markup=False, highlight=False)
    _save(folder, robot_result, answer, loaded[-1])
    terminal.print(f"Written: {folder / 'payload.json'}, {folder / 'torques.png'}", highlight=False)
    return 0


def record_runs(robot: Robot, paper: PaperTables, seed: int, count: int) -> tuple[list[Recording], list[Recording]]:
    """``count`` random trajectories, each recorded without and with the paper's payload."""
    simulator = Simulator(robot)
    unloaded, loaded = [], []
    for k in track(range(count), "simulating", console=Console(stderr=True), transient=True):
        motion = random_via_points(robot, VIA_POINTS, seed=1000 * seed + k).motion(RATE)
        name = f"trajectory {k + 1}"
        unloaded.append(simulator.record(motion, None, RX90_NOISE, [seed, k, 0], f"{name} without payload"))
        loaded.append(simulator.record(motion, paper.payload, RX90_NOISE, [seed, k, 1], f"{name} with payload"))
    return unloaded, loaded


def _tables(result: Identification, answer: PayloadAnswer, paper: PaperTables) -> tuple[Table, Table]:
    problem = answer.problem
    truth = dict(zip(result.base.columns, result.base.value(problem.robot.parameters), strict=True))
    return (
        paper_robot_table(combined(problem), truth, paper),
        paper_payload_table(answer.estimates, paper.payload, paper),
    )


def _save(folder: Path, result: Identification, answer: PayloadAnswer, held_out: Recording) -> None:
    problem = answer.problem
    robot, processing = problem.robot, problem.robot.processing
    write_json(folder / "payload.json", payload_document(answer, processing))
    observer = Observer(robot, problem.base.columns)
    observation = observer.observe(measurement(held_out, processing), processing)
    loaded = combined(problem)
    bare = result.estimate.values
    # The payload changes the base parameters as in (25)-(28).
    with_payload = loaded.values[: len(bare)] + payload_map(problem) @ loaded.values[len(bare) :]
    save_torques(
        folder / "torques.png",
        observation,
        [("predicted with payload (method 4)", with_payload), ("predicted without payload", bare)],
        "RX90 with 7.025 kg, a trajectory that was not used",
    )
