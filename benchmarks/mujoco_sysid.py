"""MuJoCo's own identification beside this program's, on the same recordings: rollouts, torques, CPU time.

Run: OPENBLAS_NUM_THREADS=1 python benchmarks/mujoco_sysid.py TRAINING HELD_OUT --robot ur10e --drive-gains K1,K2,..
     [--rollouts 60] [--cpu 240] [--step 0.002]   (needs: pip install 'mujoco[sysid]')

``mujoco.sysid`` fits ten numbers of each link (its pseudo-inertia), armature, damping and friction loss of each
joint by finite differences over open-loop rollouts of .5 s that start from filtered positions and speeds. It starts
from cylinders of half the maker's mass and the same drive in each joint. ``dynident identify`` and ``dynident robot
mjcf`` are timed as commands, start-up and imports with them; of the other the optimization alone, neither import
nor filter. It is stopped after a stated CPU time with the best model until then; whether it had ended is printed.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from dynident.apps import results
from dynident.apps.logs.read import read_recording
from dynident.apps.rollout import CONSTANT, IDENTIFIED, MujocoArm, Rollout, roll_out_all
from dynident.common.arrays import Array
from dynident.estimation.possible.prior import robot_prior
from dynident.estimation.signals.filtering import lowpass, measurement
from dynident.estimation.signals.rows import least_speed
from dynident.model import Processing, Recording, Robot, load_robot
from dynident.model.motion import Measurement
from rich.console import Console
from rich.table import Table

try:
    mujoco: Any = import_module("mujoco")
    sysid: Any = import_module("mujoco.sysid")
    sysid.optimize  # noqa: B018  an extra that is missing shows here alone
except (ImportError, AttributeError) as missing:
    print(f"MuJoCo does not import ({missing}): pip install 'mujoco[sysid]'", file=sys.stderr)
    sys.exit(2)

WINDOW = 0.5
"""s: length of the rollouts that are fitted, and the horizon that is compared."""
START = {"armature": 1.0, "damping": 5.0, "frictionloss": 5.0}
BOUNDS = {"armature": (0.0, 20.0), "damping": (0.0, 100.0), "frictionloss": (0.0, 100.0)}
"""Of each joint [kg m^2, N·m·s, N·m]."""


class Line(NamedTuple):
    """One model: rollout error after ``WINDOW`` [deg], relative torque residual, CPU time [s]."""

    rollout: float
    residual: float
    cpu: float


def identified(arguments: argparse.Namespace, folder: Path) -> float:
    """Identify and export as a user does, into ``robot.json`` and ``ours.xml``; CPU time [s]."""
    robot, document = ("--robot", arguments.robot), str(folder / "robot.json")
    options = ("--data", arguments.training, "--drive-gains", arguments.drive_gains, "--json", document, "--quiet")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    for words in (
        ("identify", *robot, *options),
        (
            "robot",
            "export",
            "--to",
            "mjcf",
            *robot,
            "--robot-parameters",
            document,
            "--out",
            str(folder / "ours.xml"),
        ),
    ):
        subprocess.run([sys.executable, "-m", "dynident", *words], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start_model(path: Path, robot: Robot) -> Any:
    """The exported kinematics with links and drives as a user might guess them; nothing identified is left."""
    spec = mujoco.MjSpec.from_file(str(path))
    for number, body in enumerate(robot_prior(robot).bodies, start=1):
        set_body(spec.body(f"link{number}"), body.mass, body.com, body.inertia_com)
    for joint in spec.joints:
        for name, value in START.items():
            set_drive(joint, name, value)
    for actuator in spec.actuators:
        actuator.biasprm[:] = 0.0
        actuator.ctrllimited = False
    return spec


def set_body(link: Any, mass: float, com: Array, inertia: Array) -> None:
    """Mass [kg], centre of mass [m] and inertia about it [kg m^2] in the link's axes."""
    link.mass, link.ipos = mass, com
    link.fullinertia = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]


def set_drive(joint: Any, name: str, value: float) -> None:
    """One number of a joint; newer versions of MuJoCo hold damping as a polynomial's coefficients."""
    current = getattr(joint, name)
    if np.ndim(current):
        current[0] = value
    else:
        setattr(joint, name, value)


def parameters(spec: Any, model: Any) -> Any:
    """What ``mujoco.sysid`` may change: ten numbers of each link, three of each joint."""
    chosen = sysid.ParameterDict()
    for number in range(1, model.nv + 1):
        link = f"link{number}"

        def write_body(changed: Any, parameter: Any, link: str = link) -> None:
            numbers = sysid.model_modifier.pi_from_theta(parameter.value)
            mass, moments, about_origin = numbers[0], numbers[1:4], numbers[4:].reshape(3, 3)
            com = moments / mass
            set_body(
                changed.body(link), mass, com, about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))
            )

        # Its own modifier compiles the model once a link: this one costs it nothing.
        kind = sysid.InertiaType.Pseudo
        chosen.add(sysid.body_inertia_param(spec.copy(), model, link, kind, modifier=write_body))
    for joint in spec.joints:
        for name, (low, high) in BOUNDS.items():

            def write(changed: Any, parameter: Any, joint: str = joint.name, name: str = name) -> None:
                set_drive(changed.joint(joint), name, float(parameter.value[0]))

            chosen.add(sysid.Parameter(f"{joint.name} {name}", START[name], low, high, modifier=write))
    return chosen


def windows(spec: Any, data: Measurement, count: int) -> Any:
    """Rollouts of ``WINDOW`` with starts spread evenly over the recording."""
    model, motion = spec.compile(), data.motion
    step = float(motion.t[1] - motion.t[0])
    length = round(WINDOW / step)
    starts = np.linspace(0, len(motion.t) - length - 1, count).astype(int).tolist()
    states, controls, sensors = [], [], []
    names = [(joint.name, sysid.SignalType.MjStateQPos) for joint in spec.joints]
    for start in starts:
        span = slice(start, start + length + 1)
        t = step * np.arange(length + 1)
        states.append(sysid.create_initial_state(model, motion.q[start], motion.qd[start]))
        controls.append(sysid.TimeSeries.from_control_names(t, data.torque[span], model))
        sensors.append(sysid.TimeSeries.from_names(t, motion.q[span], model, names))
    labels = [f"{start * step:.2f} s" for start in starts]
    return sysid.ModelSequences("arm", spec, labels, states, controls, sensors, allow_missing_sensors=True)


def difference(_: Any, __: Any, measured: Any, model: Any, ___: bool, state: Array) -> tuple[Array, Any, Any]:
    """Positions measured less predicted [rad]; its own are shares of the path, however little a joint moves."""
    t = measured.times[1:]
    predicted = np.column_stack([np.interp(t, state[:, 0], q) for q in state[:, 1 : model.nq + 1].T])
    return measured.data[1:] - predicted, measured, measured


class Search(NamedTuple):
    """What ``mujoco.sysid`` came to: model, CPU time [s], objective by iteration, whether it ended by itself."""

    spec: Any
    cpu: float
    objectives: list[float]
    ended: bool


class StoppedError(Exception):
    """The CPU time is used up."""


def fitted(arguments: argparse.Namespace, spec: Any, data: Measurement) -> Search:
    """The model that ``mujoco.sysid`` finds."""
    spec.option.timestep = arguments.step
    sequences = windows(spec, data, arguments.rollouts)
    residual = sysid.build_residual_fn(models_sequences=[sequences], n_threads=1, modify_residual=difference)
    best, ended = parameters(spec, spec.compile()), True
    objectives: list[float] = []
    before, passed = time.process_time(), [best.as_vector()]

    def watched(log: list[Any]) -> None:
        passed.append(np.ravel(log[-1].candidate).copy())
        objectives.append(float(log[-1].objective))
        used = time.process_time() - before
        print(f"{used:7.1f} s CPU, iteration {len(objectives)}: objective {objectives[-1]:.5g}", flush=True)
        if time.process_time() - before > arguments.cpu:
            raise StoppedError

    try:
        best, _ = sysid.optimize(best, residual, "mujoco", verbose=False, x_scale="jac", iter_callback=watched)
    except StoppedError:
        ended = False
        best.update_from_vector(passed[-1])
    cpu = time.process_time() - before
    return Search(sysid.apply_param_modifiers_spec(best, spec.copy()), cpu, objectives, ended)


def torque_residual(path: Path, data: Measurement, processing: Processing) -> float:
    """Norm of the model's torques less the measured ones over theirs, below the cut-off, slow rows left out."""
    model = mujoco.MjModel.from_xml_path(str(path))
    motion, friction, bias = data.motion, model.dof_frictionloss.copy(), model.actuator_biasprm[:, 0].copy()
    model.dof_frictionloss[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    state, torque = mujoco.MjData(model), np.empty_like(data.torque)
    for k in range(len(motion.t)):
        state.qpos[:], state.qvel[:], state.qacc[:] = motion.q[k], motion.qd[k], motion.qdd[k]
        mujoco.mj_inverse(model, state)
        torque[k] = state.qfrc_inverse
    torque += friction * np.sign(motion.qd) - bias
    step, speeds = float(motion.t[1] - motion.t[0]), np.abs(motion.qd)
    moving = speeds >= least_speed(speeds.max(axis=0), processing)
    ours, measured = (
        np.where(moving, lowpass(values, step, processing.cutoff, str(path)), 0.0)
        for values in (torque, data.torque)
    )
    return float(np.linalg.norm(ours - measured) / np.linalg.norm(measured))


def compare(arguments: argparse.Namespace, robot: Robot, training: Recording, held_out: Recording) -> None:
    """Identify by both, judge both on the recording held out, and print."""
    with tempfile.TemporaryDirectory() as name:
        folder, console = Path(name), Console()
        ours = identified(arguments, folder)
        console.print(f"dynident: {ours:.1f} s CPU")
        spec = start_model(folder / "ours.xml", robot)
        (folder / "start.xml").write_text(compiled(spec), encoding="utf-8")
        theirs = fitted(arguments, spec, measurement(training, robot.processing))
        (folder / "sysid.xml").write_text(compiled(theirs.spec), encoding="utf-8")
        stored = results.read_stored_robot(str(folder / "robot.json"))
        cpu = {"ours.xml": ours, "sysid.xml": theirs.cpu, "start.xml": 0.0}
        arms = {file: MujocoArm(folder / file, robot) for file in cpu}
        (rollout,) = roll_out_all(robot, stored.possible_values, [held_out], horizons=(WINDOW,), others=arms)
        data = measurement(held_out, robot.processing)
        lines = {
            file: Line(median(rollout, file), torque_residual(folder / file, data, robot.processing), seconds)
            for file, seconds in cpu.items()
        }
    end = "ended" if theirs.ended else "stopped, not ended"
    size = (
        f"{arguments.rollouts} rollouts of {WINDOW:g} s, steps of {1e3 * arguments.step:g} ms, "
        f"{len(theirs.objectives)} iterations to objective {theirs.objectives[-1]:.4g}, {end}"
    )
    console.print(table(lines, f"{held_out.source}; mujoco.sysid {mujoco.__version__}, {size}"))
    own = rollout.spread(IDENTIFIED, WINDOW)
    assert own is not None
    console.print(
        f"dynident rollout {np.degrees(own.median):.2f} deg, constant speed {median(rollout, CONSTANT):.2f} deg, "
        f"PD replay's torque {100 * rollout.replay.relative:.1f} %"
    )
    first, second = lines["ours.xml"], lines["sysid.xml"]
    console.print(f"rollout {first.rollout / second.rollout:.2f} times its (asked <= 1.1)")
    console.print(f"torque residual {100 * first.residual:.1f} % against {100 * second.residual:.1f} % (no worse)")
    console.print(f"CPU time 1/{second.cpu / first.cpu:.0f} of its (asked <= 1/50)")


def compiled(spec: Any) -> str:
    """A model as MJCF."""
    spec.compile()
    return str(spec.to_xml())


def median(rollout: Rollout, name: str) -> float:
    """Median error of a model over the starts in motion after ``WINDOW`` [deg]."""
    spread = rollout.spread(name, WINDOW)
    assert spread is not None, "no start in motion"
    return float(np.degrees(spread.median))


def table(lines: dict[str, Line], title: str) -> Table:
    """Models one below the other."""
    result = Table(title=title, box=None)
    for heading in ("model", f"rollout {WINDOW:g} s [deg]", "torque residual [%]", "CPU [s]"):
        result.add_column(heading, justify="right")
    for name, line in lines.items():
        result.add_row(name, f"{line.rollout:.2f}", f"{100 * line.residual:.1f}", f"{line.cpu:.1f}")
    return result


def main() -> None:
    """Print the comparison."""
    parser = argparse.ArgumentParser()
    parser.add_argument("training")
    parser.add_argument("held_out")
    parser.add_argument("--robot", default="ur10e")
    parser.add_argument("--drive-gains", required=True)
    parser.add_argument("--rollouts", type=int, default=60, help="of the training recording, for mujoco.sysid")
    parser.add_argument("--cpu", type=float, default=240.0, help="after which mujoco.sysid is stopped [s]")
    parser.add_argument("--step", type=float, default=0.002, help="of its simulation [s]")
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    gains = [float(word) for word in arguments.drive_gains.split(",")]
    recordings = (read_recording(path, robot, gains) for path in (arguments.training, arguments.held_out))
    compare(arguments, robot, *recordings)


if __name__ == "__main__":
    main()
