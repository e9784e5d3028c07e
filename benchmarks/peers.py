"""Other programs on the same problem: FIGAROH 1.0.2, MuJoCo's identification of a payload, adam.

Run: DYNIDENT_DATA=.. OPENBLAS_NUM_THREADS=1 python benchmarks/peers.py
     [simulated] [figaroh] [adam] [--arms tx40,..] [--runs 3] [--rollouts 60] [--cpu 240]

A peer that is not installed is left out with a line. All run in one process on one thread, and get what their own
documents and examples set where they set something.

simulated: pairs of recordings of made-up robots with the geometry of three arms, 20 s or more, exact positions,
white torque noise of 12 % of each joint's torque: base parameters without payload, then the payload.
FIGAROH's class decimates by 10 and weights by joints, at this package's cut-off; it has no payload: the one that
best explains the difference of its two fits is taken by hand. ``mujoco.sysid`` (not with ``--rollouts 0``) is given
the true arm, its dry friction taken off the torques (MuJoCo's is soft), and fits the payload alone by finite
differences to open-loop rollouts of .5 s, from a ball of half the rated payload, with wide bounds; it is stopped
after ``--cpu`` seconds with the best by then. What ``identify_payload`` answers includes intervals, a search for
faults and a verdict.

figaroh: the real TX40 recording from memory to base parameters with standard deviations. FIGAROH's class is set as
its later TX40 example sets it (100 Hz, decimation by 10, offsets), with three columns for the coupled drive; here
and above without validation on the same data, provenance and report. ``identify``, essential parameters included,
runs with the robot's own settings, and with those of the class.

adam: torques of 5,000 states of a Panda, without friction, by adam's function for CasADi and by this package's.
"""

import argparse
import contextlib
import io
import json
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from dynident.apps.export.simulators import FORMATS
from dynident.apps.logs.read import read_recording
from dynident.benchmarks import invented
from dynident.benchmarks.shared import options, recordings_folder, show
from dynident.common.arrays import Array
from dynident.estimation import Settings, identify, identify_payload, whole_robot
from dynident.estimation.signals.filtering import measurement
from dynident.model import (
    PAPER,
    InertialParameters,
    Processing,
    Recording,
    Robot,
    base_regressor,
    inverse_dynamics,
    load_robot,
    standard_columns,
)
from dynident.model.kernel.kernel import Kernel
from dynident.model.motion import Measurement
from dynident.model.regressors import _expressions as regressor_terms

CUTOFF, DECIMATE, ORDER = 100.0, 10, 4
"""FIGAROH's: Butterworth cut-off [Hz] and order, factor of decimation."""
EDGE = 5 * ORDER  # samples that its examples cut from both ends
Answer = tuple[int, int, str]  # base parameters, equations, relative residual [%]
NAMES = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", "mx", "my", "mz", "m")


class Pair(NamedTuple):
    """Recordings of one simulated motion, and what is true."""

    arm: Robot
    load: InertialParameters
    empty: Recording
    full: Recording
    other: Measurement  # another motion without payload, exact


class Found(NamedTuple):
    """The payload that a program found, errors of its base parameters and of their torques, and CPU times [s]."""

    load: InertialParameters
    base: tuple[float, float] = (np.nan, np.nan)
    robot_s: float = np.nan
    load_s: float = np.nan


def pair(name: str, run: int) -> Pair:
    """Draw the pair of a run, whose payload is of one kind after the other."""
    load = invented.payload(name, invented.PAYLOADS[run % 5], np.random.default_rng([run, 5]))
    motion, other = (invented.long_motion(name, 2 * run + k, 20.0) for k in (0, 1))
    empty, full = (invented.recorded(name, motion, body, 2 * run + k) for k, body in enumerate((None, load)))
    return Pair(invented.robot(name), load, empty, full, invented.simulator(name).measure(other))


def errors(W: Array, values: Array, torque: Array) -> tuple[float, float]:
    """Of base parameters, each times its column's norm, and of the torques on the other motion, both relative."""
    true, norms = np.linalg.lstsq(W, torque, rcond=None)[0], np.linalg.norm(W, axis=0)
    base = np.linalg.norm(norms * (values - true)) / np.linalg.norm(norms * true)
    return float(base), float(np.linalg.norm(W @ values - torque) / np.linalg.norm(torque))


def ours(case: Pair) -> Found:
    """What ``identify`` and ``identify_payload`` find."""
    regressor_terms.cache_clear()  # as at the first call: the robot's symbolic terms are built anew
    times = [time.process_time()]
    robot = identify(case.arm, [case.empty], Settings(friction=case.arm.drives.friction))  # as FIGAROH's
    times.append(time.process_time())
    found = identify_payload(case.arm, [case.full], [case.empty])
    times.append(time.process_time())
    kernel, motion = Kernel(base_regressor(robot.robot, robot.base)), case.other.motion
    W = np.zeros((case.arm.n, len(motion.t), len(robot.base.columns)))
    W[kernel.rows, :, kernel.columns] = kernel(motion.q, motion.qd, motion.qdd)
    base = errors(np.vstack(list(W)), robot.estimate.values, case.other.torque.T.ravel())
    body = InertialParameters.from_com(found.mass.value, found.com.value, found.inertia.value)
    return Found(body, base, *np.diff(times).tolist())


def figarohs(case: Pair) -> Found:
    """What FIGAROH's class finds, and the payload that best explains the difference."""
    problems, times = [], list[float]()
    for recording in (case.empty, case.full):
        problem = figaroh_problem(case.arm, recording, case.arm.processing.cutoff or CUTOFF)
        start = time.process_time()
        figaroh_class(problem)
        times.append(time.process_time() - start)
        problems.append(problem)
    fit, motion = problems[0], case.other.motion
    fit.processed_data = {"positions": motion.q, "velocities": motion.qd, "accelerations": motion.qdd}
    fit.calculate_full_regressor()
    W = np.delete(fit.dynamic_regressor, fit._idx_eliminated, axis=1)[:, list(fit._base_indices)]
    last = [list(fit.standard_parameter).index(f"{name}_{fit.model.names[-1]}") for name in NAMES]
    size = np.repeat(np.sqrt(np.mean(case.other.torque**2, axis=0)), len(motion.t))  # weights the joints
    change = W @ (problems[1].phi_base - fit.phi_base) / size
    body = np.linalg.lstsq(fit.dynamic_regressor[:, last] / size[:, None], change, rcond=None)[0]
    base = errors(W, fit.phi_base, case.other.torque.T.ravel())
    return Found(InertialParameters(body), base, times[0], sum(times))


def sysids(case: Pair, arguments: argparse.Namespace) -> Found:
    """What ``mujoco.sysid`` finds of a payload on the true arm without dry friction: MuJoCo's is soft."""
    import mujoco

    own, robot = case.arm.parameters, invented.simulator(case.arm.name)
    slippery = {name: 0.0 if name.startswith("FS") else value for name, value in own.items()}
    data = measurement(case.full, case.arm.processing)
    exact, without = (robot.measure(data.motion, parameters=values).torque for values in (own, slippery))
    data = Measurement(data.motion, data.torque - exact + without)
    whole = whole_robot(case.arm, slippery, "made up")
    spec = mujoco.MjSpec.from_string(FORMATS["mjcf"].text(whole))
    for actuator in spec.actuators:
        actuator.ctrllimited = False
    load = spec.body(whole.link_names[-1]).add_body(name="payload")
    mass = 0.5 * (case.arm.rated_payload or 2.0 * invented.CAPACITY[case.arm.name])
    set_body(load, mass, np.array([0.0, 0.0, 0.1]), 0.4 * mass * 0.05**2 * np.eye(3))
    found, spent = fitted(arguments, spec, data, "payload")
    body = found.body("payload")
    xx, yy, zz, xy, xz, yz = body.fullinertia
    load = InertialParameters.from_com(body.mass, body.ipos, [xx, xy, xz, yy, yz, zz])
    return Found(load, load_s=spent)


def simulated(arguments: argparse.Namespace) -> None:
    """Print errors and times on simulated pairs."""
    programs: dict[str, Callable[[Pair], Found]] = {
        "dynident": ours,
        "FIGAROH": figarohs,
        "mujoco.sysid": lambda case: sysids(case, arguments),
    }
    headings = "centre of mass mm", "inertia %", "base parameters %", "torque %", "robot s", "payload s"
    for name in arguments.arms.split(","):
        rows: dict[str, list[list[float]]] = {title: [] for title in programs}
        for run in range(-1, arguments.runs):
            case = pair(name, max(run, 0))
            for title, ask in list(programs.items())[: 3 if run >= 0 and arguments.rollouts else 2]:
                with contextlib.redirect_stdout(io.StringIO()):
                    found = ask(case)
                mass, inertia = case.load.mass, case.load.inertia_com
                off = [
                    100.0 * abs(found.load.mass / mass - 1.0),
                    1e3 * float(np.linalg.norm(found.load.com - case.load.com)),
                    100.0 * float(np.linalg.norm(found.load.inertia_com - inertia) / np.linalg.norm(inertia)),
                ]
                if run >= 0:  # the one before imports, and compiles into the cache
                    rows[title].append([*off, *(100.0 * x for x in found.base), found.robot_s, found.load_s])
        medians = {title: np.median(own, axis=0) for title, own in rows.items() if own}
        lines = [
            [title, *(f"{x:.2g}" for x in own), *(f"{x:.1f}" for x in own[-2:] / medians["dynident"][-2:])]
            for title, own in medians.items()
        ]
        title = f"{name}, simulated: errors and CPU time, medians of {arguments.runs} runs; seen: the mass in %"
        show(title, lines, *headings, "robot x", "payload x", asked=False)


def figaroh(arguments: argparse.Namespace) -> None:
    """Print times, how many times longer FIGAROH takes, and what each found."""
    folder = recordings_folder("figaroh")
    if folder is None:
        return
    robot = load_robot("tx40")
    bodies = invented.robot("tx40").with_offsets(True)  # which play no part in FIGAROH's regressor
    recording = read_recording(folder / "tx40" / "tx40.csv.gz", robot)
    later = Processing(cutoff=CUTOFF, decimate=DECIMATE, still_speed=0.0)

    def own(arm: Robot, processing: Processing) -> Answer:
        regressor_terms.cache_clear()  # as at the first call: the robot's symbolic terms are built anew
        result = identify(arm, [recording], Settings(processing, robust=False, friction=PAPER))
        return len(result.estimate.sigma), result.problem.equations, f"{100 * result.estimate.fit.relative:.2f}"

    arms = {"dynident": (robot, robot.processing), "dynident, set as FIGAROH": (robot.with_offsets(True), later)}
    times: dict[str, list[float]] = {title: [] for title in ("FIGAROH", *arms)}
    answers: dict[str, Answer] = {}
    for turn in range(arguments.runs + 1):
        for title, spent in times.items():
            with contextlib.redirect_stdout(io.StringIO()):
                problem = figaroh_problem(bodies, recording, CUTOFF)
                start = time.process_time()
                answers[title] = own(*arms[title]) if title in arms else figaroh_class(problem)
            if turn:  # the first one imports, and compiles into the cache
                spent.append(time.process_time() - start)
    medians = {title: float(np.median(spent)) for title, spent in times.items()}
    lines = [
        [title, f"{spent:.3f}", f"{spent / medians['dynident']:.1f}", *map(str, answers[title])]
        for title, spent in medians.items()
    ]
    title = f"TX40 recording, CPU seconds, medians of {arguments.runs} rounds"
    show(title, lines, "in dynident's", "parameters", "equations", "residual %", asked=False)


def figaroh_problem(robot: Robot, recording: Recording, cutoff: float) -> Any:
    """FIGAROH's identification as its later TX40 example writes it, the estimation alone."""
    from figaroh.identification.base_identification import BaseIdentification
    from figaroh.tools.robot import Robot as FigarohRobot

    class Arm(BaseIdentification):  # type: ignore[misc]  # FIGAROH has no types
        dynamic_regressor: Array

        def load_trajectory_data(self, data_source: str | None = None) -> dict[str, Array | None]:
            data = {"timestamps": recording.t, "positions": recording.q, "torques": recording.torque}
            return {**data, "velocities": None, "accelerations": None}

        def process_torque_data(self, **_: Any) -> Array:
            for name, signal in self.processed_data.items():  # what the filter spoils goes from both ends
                self.processed_data[name] = signal[EDGE:-EDGE]
            return np.asarray(self.raw_data["torques"][EDGE:-EDGE])

        def calculate_full_regressor(self) -> None:
            super().calculate_full_regressor()
            if robot.drives.coupling is None:
                return
            qd, qdd = self.processed_data["velocities"], self.processed_data["accelerations"]
            columns = np.zeros((robot.n, len(qd), 3))  # of rotor 6
            for row, partner in ((4, 5), (5, 4)):
                columns[row] = np.column_stack([qdd[:, partner], qd[:, partner], np.sign(qd[:, 4] + qd[:, 5])])
            self.dynamic_regressor = np.hstack([self.dynamic_regressor, columns.reshape(-1, 3)])

        def initialize_standard_parameters(self) -> None:
            super().initialize_standard_parameters()
            if robot.drives.coupling is not None:
                self.standard_parameter |= dict.fromkeys(("Iam6", "fvm6", "fsm6"), 0.0)

        def _store_results(self, identif_results: dict[str, Any]) -> None:
            self.result = identif_results

        def print_quality_report(self) -> None:
            pass

    whole, columns = whole_robot(robot, dict(robot.parameters), "made up"), standard_columns(robot)
    kinds = {"friction": "FS1", "actuator_inertia": "IA1", "joint_offset": "OFF1"}
    components = {kind: name in columns for kind, name in kinds.items()}
    rate = (len(recording.t) - 1) / float(recording.t[-1] - recording.t[0])
    task = {
        "problem": {"use_joint_torques": True, "wls": True, "model_components": components},
        "signal_processing": {"sampling_frequency": rate, "cutoff_frequency": cutoff, "filter_order": ORDER},
    }
    properties = {"joints": {"active_joints": list(whole.joint_names)}}
    document = {"robot": {"name": robot.name, "properties": properties}, "tasks": {"identification": task}}
    with tempfile.TemporaryDirectory() as folder:
        model, settings = Path(folder) / "robot.urdf", Path(folder) / "robot.yaml"
        model.write_text(FORMATS["urdf"].text(whole), encoding="utf-8")
        settings.write_text(json.dumps(document), encoding="utf-8")  # JSON is YAML
        problem = Arm(FigarohRobot(str(model), folder), str(settings))
    every = list(range(robot.n))
    problem.identif_config |= {"act_idxq": every, "act_idxv": every, "act_Jid": [j + 1 for j in every]}
    filtering = {"nbutter": ORDER, "f_butter": cutoff, "f_sample": 1 / problem.identif_config["ts"]}
    problem.filter_config = {"differentiation_method": "gradient", "filter_params": filtering}
    return problem


def figaroh_class(problem: Any) -> Answer:
    """Its class: initialize and solve."""
    problem.initialize()
    problem.solve(decimate=True, decimation_factor=DECIMATE, wls=True, plotting=False)
    error = np.linalg.norm(problem.tau_noised - problem.tau_identif) / np.linalg.norm(problem.tau_noised)
    return len(problem.result["wls_std_deviations"]), len(problem.tau_noised), f"{100 * error:.2f}"


WINDOW, STEP = 0.5, 0.002
"""s: length of the rollouts that are fitted; step of the simulation."""
STRETCH = np.array([0.02, 50.0])
"""Bounds of second moments over mass, times those at the start; the default, a factor of 2, is too narrow."""


class StoppedError(Exception):
    """The CPU time is used up."""


def set_body(link: Any, mass: float, com: Array, inertia: Array) -> None:
    """Mass [kg], centre of mass [m] and inertia about it [kg m^2] in the link's axes."""
    link.mass, link.ipos = mass, com
    link.fullinertia = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]


def positions_off(*given: Any, state: Array) -> tuple[Array, Any, Any]:
    """Differences of positions [rad]: its own are shares of the path, however little a joint moves."""
    measured, model = given[2:4]
    predicted = [np.interp(measured.times[1:], state[:, 0], q) for q in state[:, 1 : model.nq + 1].T]
    return measured.data[1:] - np.column_stack(predicted), measured, measured


def fitted(arguments: argparse.Namespace, spec: Any, data: Measurement, link: str) -> tuple[Any, float]:
    """The model that ``mujoco.sysid`` finds of a link, and its CPU time [s]."""
    from mujoco import sysid

    spec.option.timestep = STEP
    model = spec.compile()
    best = sysid.ParameterDict()

    def write_body(changed: Any, parameter: Any) -> None:
        numbers = sysid.model_modifier.pi_from_theta(parameter.value)
        mass, moments, about_origin = numbers[0], numbers[1:4], numbers[4:].reshape(3, 3)
        com = moments / mass
        about_com = about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))
        set_body(changed.body(link), mass, com, about_com)

    # Its own modifier compiles the model once a link: this one costs it nothing.
    kind = sysid.InertiaType.Pseudo
    best.add(
        sysid.body_inertia_param(spec.copy(), model, link, kind, modifier=write_body, stretch_bound_mult=STRETCH)
    )
    motion = data.motion
    step = float(motion.t[1] - motion.t[0])
    length = round(WINDOW / step)
    starts = np.linspace(0, len(motion.t) - length - 1, arguments.rollouts).astype(int).tolist()
    spans, t = [slice(start, start + length + 1) for start in starts], step * np.arange(length + 1)
    signals = [(joint.name, sysid.SignalType.MjStateQPos) for joint in spec.joints]
    sequences = sysid.ModelSequences(
        "arm",
        spec,
        [f"{start * step:.2f} s" for start in starts],
        [sysid.create_initial_state(model, motion.q[start], motion.qd[start]) for start in starts],
        [sysid.TimeSeries.from_control_names(t, data.torque[span], model) for span in spans],
        [sysid.TimeSeries.from_names(t, motion.q[span], model, signals) for span in spans],
        allow_missing_sensors=True,
    )

    residual = sysid.build_residual_fn(models_sequences=[sequences], n_threads=1, modify_residual=positions_off)
    before, passed = time.process_time(), [best.as_vector()]

    def watched(log: list[Any]) -> None:
        passed.append(np.ravel(log[-1].candidate).copy())
        if time.process_time() - before > arguments.cpu:
            raise StoppedError

    try:
        with contextlib.redirect_stdout(io.StringIO()):
            best, _ = sysid.optimize(best, residual, "mujoco", verbose=False, x_scale="jac", iter_callback=watched)
    except StoppedError:
        best.update_from_vector(passed[-1])
    return sysid.apply_param_modifiers_spec(best, spec.copy()), time.process_time() - before


def adam(arguments: argparse.Namespace) -> None:
    """Print times of the torques of many states, and how far they lie apart."""
    from adam.casadi import KinDynComputations

    arm = invented.robot("panda")
    chi = np.array([0.0 if name[:2] in ("FS", "FV") else arm.parameters[name] for name in standard_columns(arm)])
    whole, states = whole_robot(arm, dict(arm.parameters), ""), [ca.SX.sym(x, arm.n) for x in "qva"]
    with contextlib.redirect_stderr(io.StringIO()):  # URDF elements of Drake's
        theirs = KinDynComputations(FORMATS["urdf"].text(whole), list(whole.joint_names))
    theirs.g = np.append(arm.gravity, np.zeros(3))
    mass = theirs.mass_matrix_fun()(np.eye(4), states[0])[6:, 6:]
    bias = theirs.bias_force_fun()(np.eye(4), states[0], np.zeros(6), states[1])[6:]
    samples = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5000, arm.n))
    virtual = ca.Function("torque", states, [mass @ states[2] + bias]).map(5000)
    own, kernel, turned = inverse_dynamics(arm).map(5000), Kernel(inverse_dynamics(arm)), [x.T for x in samples]
    ways: dict[str, Callable[[], Any]] = {
        "adam in CasADi's virtual machine": lambda: virtual(*turned),
        "dynident in CasADi's virtual machine": lambda: own(*turned, chi),
        "dynident, compiled": lambda: kernel(*samples, chi),
    }
    rows = []
    for title, run in ways.items():
        off, start = np.abs(np.asarray(run()) - np.asarray(own(*turned, chi))).max(), time.process_time()
        for _ in range(arguments.runs):
            run()
        nanoseconds = 1e9 * (time.process_time() - start) / arguments.runs / 5000
        rows.append([title, f"{nanoseconds:.0f}", f"{off:.0e}"])
    show("Panda, torques of a state [ns], without friction", rows, "apart by N·m", asked=False)


def main() -> None:
    sysid = "mujoco.sysid.report.defaults"  # not there without MuJoCo's extra
    peers = {
        "simulated": (simulated, ("figaroh.identification", sysid), "figaroh==1.0.2 'mujoco[sysid]'"),
        "figaroh": (figaroh, ("figaroh.identification",), "figaroh==1.0.2"),
        "adam": (adam, ("adam.casadi",), "'adam-robotics[casadi]'"),
    }
    arguments = options(__doc__, peers=tuple(peers), arms="tx40,ur10e,panda", runs=3, rollouts=60, cpu=240.0)
    for name in arguments.peers:
        run, modules, package = peers[name]
        try:
            list(map(import_module, modules))
        except ImportError as missing:
            print(f"{name}: left out, not installed ({missing}): pip install {package}")
        else:
            run(arguments)


if __name__ == "__main__":
    main()
