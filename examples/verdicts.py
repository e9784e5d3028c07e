"""Each verdict once, and the figure that shows why, from simulated recordings of the Stäubli RX90.

Writes the page ``gallery.md`` and its figures: ``python -m dynident.examples.verdicts --out docs``.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from dynident import InertialParameters, Simulator, identify_payload, load_robot
from dynident.apps.report.figures import save_figure
from dynident.common.files import write_text
from dynident.estimation import GainsResult, PayloadResult, answer_gains
from dynident.estimation.answers.gains import gain_problem, known_mass
from dynident.model import Recording
from dynident.trajectories import RX90_NOISE, random_via_points

ROBOT = load_robot("rx90")
HEAD = """# What each verdict looks like

Four results from simulated recordings of the Stäubli RX90, three of a payload and one of drive gains, each with its
screen and the figure that shows why. This page is made by `python -m dynident.examples.verdicts --out docs`.
[What to do with each verdict](how-to/verdict.md) is on its own page, and so are [the checks](verdict.md).
"""


@dataclass(frozen=True)
class Shown:
    """A verdict: its name, what was recorded, the answer, and which figure shows it."""

    name: str
    words: str
    answer: PayloadResult | GainsResult
    figure: str


def recorded(load: InertialParameters, speed: float, seed: int) -> tuple[Recording, Recording]:
    """A random motion without and with a payload, at a share of the speed limits."""
    arm, motion = Simulator(ROBOT), random_via_points(ROBOT, 14, seed, speed).motion(rate=200.0)
    bare, heavy = (arm.record(motion, body, RX90_NOISE, seed=k) for k, body in enumerate((None, load)))
    return bare, heavy


def good() -> Shown:
    """A heavy payload on a fast motion."""
    load = InertialParameters.from_com(7.0, [0.0, 0.02, 0.14], [0.25, 0.3, 0.2])
    bare, heavy = recorded(load, 0.9, 1)
    answer = identify_payload(ROBOT, [heavy], [bare])
    return Shown(
        "use", "7 kg, half a metre long, on a fast motion: all ten numbers can be used.", answer, "by_joints"
    )


def slow() -> Shown:
    """A small payload on a slow motion."""
    load = InertialParameters.from_com(3.0, [0.0, 0.01, 0.08], [0.004, 0.004, 0.003])
    bare, heavy = recorded(load, 0.12, 2)
    answer = identify_payload(ROBOT, [heavy], [bare])
    words = "3 kg, the size of a fist, on a slow motion: gravity shows mass and centre of mass, inertia hardly."
    return Shown("mass_and_com_only", words, answer, "flange")


def scaled() -> Shown:
    """The torque of joint 3 comes out a tenth too small under load."""
    load = InertialParameters.from_com(7.0, [0.0, 0.02, 0.14], [0.25, 0.3, 0.2])
    bare, heavy = recorded(load, 0.9, 1)
    torque = np.array(heavy.torque)
    torque[:, 2] *= 0.9
    answer = identify_payload(ROBOT, [replace(heavy, torque=torque)], [bare])
    words = "The first payload again, the torque of joint 3 logged 10 % too small under load: the joints disagree."
    return Shown("do_not_use", words, answer, "by_joints")


def slow_currents() -> Shown:
    """Currents of a slow motion: no gravity acts on joint 1, and its inertia hardly shows."""
    load = InertialParameters.from_com(7.0, [0.08, 0.02, 0.14], [0.25, 0.3, 0.2])
    gains = np.array([50.0, 60.0, 40.0, 20.0, 15.0, 10.0])
    recordings = []
    for recording in recorded(load, 0.45, 1):
        motors = ROBOT.coupling.motor_torques(recording.torque) if ROBOT.coupling else recording.torque
        recordings.append(replace(recording, torque=motors / gains))
    bare, heavy = recordings
    known = known_mass(7.0)
    answer = answer_gains(gain_problem(ROBOT, [bare], [heavy], known))
    words = (
        "Drive gains from currents and a weight of 7 kg, slow motion: gravity does not show the gain of motor 1."
    )
    return Shown("identified_only", words, answer, "by_joints_1")


def main() -> None:
    """Write the page and its figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("gallery"), help="folder (default: gallery)")
    folder = parser.parse_args().out
    (folder / "gallery").mkdir(parents=True, exist_ok=True)
    parts = [HEAD]
    for make in (good, slow, slow_currents, scaled):
        shown = make()
        level = shown.answer.to_dict()["verdict"]["level"]
        print(f"{shown.name}: {shown.answer!r}", flush=True)
        picture = f"gallery/{shown.name}.png"
        figure = shown.answer.plot(shown.figure or None)
        figure.set_dpi(80)
        save_figure(figure, folder / picture)
        parts += [
            f"## `{level}`\n",
            f"{shown.words}\n",
            f"```text\n{shown.answer}\n```\n",
            f"![{shown.words}]({picture})\n",
        ]
    write_text(folder / "gallery.md", "\n".join(parts))


if __name__ == "__main__":
    main()
