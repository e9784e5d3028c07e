"""Figures of an identification, of a payload and of a designed motion, each by one line of Python.

Writes the page ``figures.md`` and its pictures: ``python -m dynident.examples.figures --out docs``.
"""

import argparse
from pathlib import Path
from typing import Any

from dynident import (
    RX90_NOISE,
    InertialParameters,
    Simulator,
    identify,
    identify_payload,
    load_robot,
    random_via_points,
)
from dynident.apps.report.figures import save_figure
from dynident.common.files import write_text
from dynident.trajectories import Goal, ViaPointShape, build_design, solve_design

HEAD = """# Figures

Each figure is one line of Python, and stands in the pages that `--report` writes as well. They are of simulated
recordings of a Stäubli RX90 without and with 7 kg. This page is made by
`python -m dynident.examples.figures --out docs`.
"""
FIGURES = (
    ("payload", "flange", "Mass and centre of mass", "The payload seen from two sides, with its 95 % intervals."),
    ("payload", "methods", "The methods side by side", "What each of the paper's methods says, as intervals."),
    ("payload", "by_joints", "Joint by joint", "How much of the payload each joint shows."),
    ("robot", "worst_joint", "Measured and predicted", "The joint that the identified robot fits least."),
    ("robot", "essential_path", "Essential parameters", "What the error does as parameters leave, (21)."),
    ("design", "motion", "A designed motion", "Positions and speeds between their limits, over time."),
)
"""Of what, the figure's name, its heading and what it shows."""
DPI = 72


def results() -> dict[str, Any]:
    """A payload, a robot and a motion."""
    robot = load_robot("rx90")
    arm, motion = Simulator(robot), random_via_points(robot, count=14, seed=1).motion(rate=200.0)
    body = InertialParameters.from_com(7.0, [0.0, 0.02, 0.14], [0.05, 0.06, 0.04])
    unloaded, loaded = (arm.record(motion, load, RX90_NOISE, seed=k) for k, load in enumerate((None, body)))
    return {
        "payload": identify_payload(robot, [loaded], [unloaded]),
        "robot": identify(robot, [unloaded]),
        "design": solve_design(build_design(robot, ViaPointShape(count=10), Goal("d")), seed=1, starts=1),
    }


def main() -> None:
    """Write the page and its pictures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder (default: figures)")
    folder = parser.parse_args().out
    (folder / "images").mkdir(parents=True, exist_ok=True)
    made, parts = results(), [HEAD]
    for of, name, heading, words in FIGURES:
        picture = f"images/{of}_{name}.png"
        figure = made[of].plot(name)
        figure.set_dpi(DPI)
        save_figure(figure, folder / picture, dpi=DPI)
        call = f'{of}.plot("{name}")'
        parts += [f"## {heading}\n", f"{words} `{call}`\n", f"![{words}]({picture})\n"]
    write_text(folder / "figures.md", "\n".join(parts))


if __name__ == "__main__":
    main()
