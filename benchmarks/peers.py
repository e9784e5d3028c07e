"""Other programs on the same problem: FIGAROH, MuJoCo's identification, and black-box searches of a motion.

Run: DYNIDENT_DATA=.. OPENBLAS_NUM_THREADS=1 python benchmarks/peers.py [figaroh] [mujoco] [searches]
     [--rounds 5] [--rollouts 60] [--cpu 240]

A peer that is not installed is left out with a line. All run in one process on one thread.

figaroh: the real TX40 recording from memory to base parameters with standard deviations, by FIGAROH 1.0.2. It goes
four ways: *functions* is the sequence of functions that its TX40 script calls, base parameters from 50,000 random
states included (100 Hz, decimation 10 x 10, offsets, coupled axes; without the script's dense weight matrices and
essential parameters); *recording* the same with base parameters from the recording; *class* ``initialize`` and
``solve`` of its base class, set as its later TX40 example sets them (100 Hz, decimation by 10; no coupling, as
there); *bare* the same without validation on the same data, provenance and report. ``identify``, essential
parameters included, runs with the robot's own settings, and with those of the functions and of the class.

mujoco: ``mujoco.sysid`` fits ten numbers of each link, armature, damping and friction loss of each joint of a real
UR10e by finite differences over ``--rollouts`` open-loop rollouts of .5 s. It starts from cylinders of half the
maker's mass and the same drive in each joint, and is stopped after ``--cpu`` seconds with the best model by then.
Both are judged by rollouts of another recording.

searches: random search and CMA-ES of a motion by this package's compiled criterion.
"""

import argparse
import contextlib
import io
import json
import math
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from dynident.apps import results
from dynident.apps.logs.read import read_recording
from dynident.apps.rollout.arm import mujoco_arm
from dynident.apps.rollout.rollout import roll_out_all
from dynident.benchmarks.random_motions import random_motion, random_motions
from dynident.benchmarks.shared import UR10E_GAINS, options, recordings_folder, show
from dynident.cli import main as main_of
from dynident.common.arrays import Array
from dynident.estimation import Settings, identify
from dynident.estimation.possible.prior import robot_prior
from dynident.estimation.signals.filtering import measurement
from dynident.model import PAPER, Processing, Recording, Robot, load_robot
from dynident.model.motion import Measurement
from dynident.model.regressors import _terms as regressor_terms
from dynident.trajectories import Goal, ViaPointShape, build_design, solve_design
from dynident.trajectories.design.limits import excess
from scipy.signal import decimate

CUTOFF, DECIMATE, ORDER = 100.0, 10, 4
"""FIGAROH's: Butterworth cut-off [Hz] and order, factor of decimation."""
EDGE = 5 * ORDER
"""Samples that its examples cut from both ends."""
RANDOM_STATES, RANGES = 50_000, (6.0, 10.0, 30.0)
"""Its script's, for q [rad], qd, qdd."""
TINY = 1e-6, 1e-3
"""Columns below are left out of random states, of the recording: its script's."""
Answer = tuple[int, int, str]
"""Numbers of base parameters and equations, relative residual in percent."""


def figaroh(arguments: argparse.Namespace) -> None:
    """Print times, how many times longer FIGAROH takes, and what each found."""
    import figaroh.identification  # noqa: F401  a peer that is missing shows here

    folder = recordings_folder("figaroh")
    if folder is None:
        return
    robot = load_robot("tx40")
    recording = read_recording(folder / "tx40" / "tx40.csv.gz", robot)
    own, wide, slow = robot.processing, robot.with_offsets(True), robot.processing.slow_fraction
    uncoupled = replace(wide, drives=replace(wide.drives, coupling=None))
    script = Processing(cutoff=CUTOFF, decimate=DECIMATE**2, still_speed=0.0, slow_fraction=own.slow_fraction)
    later = Processing(cutoff=CUTOFF, decimate=DECIMATE, still_speed=0.0)

    def ours(arm: Robot, processing: Processing) -> Answer:
        regressor_terms.cache_clear()  # as at the first call: the robot's symbolic terms are built anew
        result = identify(arm, [recording], Settings(processing, robust=False, friction=PAPER))
        return len(result.estimate.sigma), result.problem.equations, f"{100 * result.estimate.fit.relative:.2f}"

    def theirs(structural: bool) -> Callable[[], Answer]:
        return figaroh_functions(figaroh_problem(robot, recording), recording, slow, structural)

    ways: dict[str, Callable[[], Callable[[], Answer]]] = {
        "FIGAROH, functions": lambda: theirs(structural=True),
        "FIGAROH, recording": lambda: theirs(structural=False),
        "FIGAROH, class": lambda: figaroh_class(figaroh_problem(robot, recording)),
        "FIGAROH, bare": lambda: figaroh_class(figaroh_problem(robot, recording, bare=True)),
        "dynident": lambda: lambda: ours(robot, own),
        "dynident, as the functions": lambda: lambda: ours(wide, script),
        "dynident, as the class": lambda: lambda: ours(uncoupled, later),
    }
    times: dict[str, list[float]] = {title: [] for title in ways}
    answers: dict[str, Answer] = {}
    for turn in range(arguments.rounds + 1):
        for title, prepare in list(ways.items())[turn == 0 :]:
            with contextlib.redirect_stdout(io.StringIO()):
                run = prepare()
                start = time.process_time()
                answers[title] = run()
            if turn:  # the first one imports, and compiles into the cache
                times[title].append(time.process_time() - start)
    medians = {title: float(np.median(own)) for title, own in times.items()}
    lines = [
        [title, f"{own:.3f}", *(f"{reference / own:.1f}" for reference in list(medians.values())[:4])]
        for title, own in medians.items()
    ]
    show(
        f"TX40 recording, CPU seconds, medians of {arguments.rounds} rounds; how many times longer FIGAROH takes",
        [[*line, *map(str, answers[line[0]])] for line in lines],
        *("functions", "recording", "class", "bare", "parameters", "equations", "residual %"),
        asked=False,
    )


def figaroh_problem(robot: Robot, recording: Recording, bare: bool = False) -> Any:
    """FIGAROH's identification of the TX40, as its later example writes it; ``bare``: the estimation alone."""
    import pinocchio as pin
    from figaroh.identification.base_identification import BaseIdentification
    from figaroh.tools.robot import Robot as FigarohRobot

    class Tx40(BaseIdentification):  # type: ignore[misc]  # FIGAROH has no types
        def load_trajectory_data(self, data_source: str | None = None) -> dict[str, Array | None]:
            data = {"timestamps": recording.t, "positions": recording.q, "torques": recording.torque}
            return {**data, "velocities": None, "accelerations": None}

        def process_torque_data(self, **_: Any) -> Array:
            for name, signal in self.processed_data.items():  # what the filter spoils goes from both ends
                self.processed_data[name] = signal[EDGE:-EDGE]
            return np.asarray(self.raw_data["torques"][EDGE:-EDGE])

    class Bare(Tx40):
        def _store_results(self, identif_results: dict[str, Any]) -> None:
            self.result = identif_results

        def print_quality_report(self) -> None:
            pass

    # The bodies' numbers play no part in a regressor.
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
    parts = ['<link name="link0"/>']
    for j, joint in enumerate(robot.joints, start=1):
        turn = pin.utils.rotate("x", joint.alpha) @ pin.utils.rotate("z", joint.theta)
        place = turn @ [0.0, 0.0, joint.r] + [joint.d, 0.0, 0.0]
        rpy, xyz = (" ".join(repr(float(x)) for x in row) for row in (pin.rpy.matrixToRpy(turn), place))
        parts += [
            f'<link name="link{j}">{body}',
            f'<joint name="joint{j}" type="revolute"><parent link="link{j - 1}"/><child link="link{j}"/>',
            f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/>',
            f'<limit lower="{-2 * math.pi}" upper="{2 * math.pi}" effort="1" velocity="1"/></joint>',
        ]
    rate = (len(recording.t) - 1) / float(recording.t[-1] - recording.t[0])
    components = dict.fromkeys(("friction", "joint_offset", "actuator_inertia"), True)
    task = {
        "problem": {"use_joint_torques": True, "wls": True, "model_components": components},
        "signal_processing": {"sampling_frequency": rate, "cutoff_frequency": CUTOFF, "filter_order": ORDER},
    }
    joints = {"active_joints": [f"joint{j}" for j in range(1, robot.n + 1)]}
    properties = {"joints": joints, "coupling": {"has_coupled_wrist": True}}
    document = {"robot": {"name": robot.name, "properties": properties}, "tasks": {"identification": task}}
    with tempfile.TemporaryDirectory() as folder:
        model, settings = Path(folder) / "robot.urdf", Path(folder) / "robot.yaml"
        model.write_text(f'<robot name="{robot.name}">{"".join(parts)}</robot>', encoding="utf-8")
        settings.write_text(json.dumps(document), encoding="utf-8")  # JSON is YAML
        problem = (Bare if bare else Tx40)(FigarohRobot(str(model), folder), str(settings))
    every = list(range(robot.n))
    problem.identif_config |= {"act_idxq": every, "act_idxv": every, "act_Jid": [j + 1 for j in every]}
    filtering = {"nbutter": ORDER, "f_butter": CUTOFF, "f_sample": 1 / problem.identif_config["ts"]}
    problem.filter_config = {"differentiation_method": "gradient", "filter_params": filtering}
    return problem


def figaroh_class(problem: Any) -> Callable[[], Answer]:
    """Its class: initialize and solve."""

    def run() -> Answer:
        problem.initialize()
        problem.solve(decimate=True, decimation_factor=DECIMATE, wls=True, plotting=False)
        error = np.linalg.norm(problem.tau_noised - problem.tau_identif) / np.linalg.norm(problem.tau_noised)
        return len(problem.result["wls_std_deviations"]), len(problem.tau_noised), f"{100 * error:.2f}"

    return run


def figaroh_functions(problem: Any, recording: Recording, slow: float, structural: bool) -> Callable[[], Answer]:
    """The steps of its script: ``structural`` base parameters first, then those that the recording shows."""
    from figaroh.identification import identification_tools as tools
    from figaroh.identification.parameter import add_standard_additional_parameters, get_standard_parameters
    from figaroh.tools import regressor as regressors
    from figaroh.tools.qrdecomposition import QRDecomposer, get_baseParams

    theirs, settings, n = problem.robot, problem.identif_config, problem.robot.model.nv

    def regressor(q: Array, qd: Array, qdd: Array) -> Array:
        """FIGAROH's, joint by joint, and three columns for rotor 6."""
        columns = np.zeros((n, len(q), 3))
        for row, partner in ((4, 5), (5, 4)):
            columns[row] = np.column_stack([qdd[:, partner], qd[:, partner], np.sign(qd[:, 4] + qd[:, 5])])
        W = regressors.build_regressor_basic(theirs, q, qd, qdd, settings)
        return np.hstack([W, columns.reshape(-1, 3)])

    def twice(signal: Array) -> Array:
        return np.asarray(decimate(decimate(signal, DECIMATE, zero_phase=True), DECIMATE, zero_phase=True))

    def run() -> Answer:
        standard = get_standard_parameters(theirs.model, settings)
        standard |= add_standard_additional_parameters(theirs.model, settings)
        standard |= dict.fromkeys(("Iam6", "fvm6", "fsm6"), 0.0)
        if structural:
            draw = np.random.default_rng(0)
            W = regressor(*(draw.uniform(-x, x, (RANDOM_STATES, n)) for x in RANGES))
            absent, names = regressors.get_index_eliminate(W, standard, TINY[0])
            get_baseParams(regressors.build_regressor_reduced(W, absent), names, standard)
        q = tools.low_pass_filter_data(recording.q, settings, ORDER)
        q, qd, qdd = tools.calculate_first_second_order_differentiation(theirs.model, q, settings)
        W, Y = regressor(q, qd, qdd).reshape(n, len(q), -1), recording.torque[EDGE : EDGE + len(q)]
        rows, torques = [], []
        for j in range(n):
            wide = np.column_stack([twice(w) for w in W[j].T])
            speed = np.abs(wide[:, list(standard).index(f"fv_joint{j + 1}")])
            keep = speed >= slow * speed.max()
            rows.append(wide[keep])
            torques.append(twice(Y[:, j])[keep])
        W_e, names = regressors.eliminate_non_dynaffect(np.vstack(rows), standard, TINY[1])
        y = np.concatenate(torques)
        W_b, _, _, values = QRDecomposer().double_decomposition(y, W_e, names)
        # The script's last step, each joint's rows over their error's norm: FIGAROH has it in its class alone.
        errors = np.split(y - W_b @ values, np.cumsum([len(part) for part in torques])[:-1])
        sigma = np.concatenate([np.full(len(part), np.sqrt(np.mean(part**2))) for part in errors])
        covariance = np.linalg.inv((W_b / sigma[:, None]).T @ (W_b / sigma[:, None]))
        values = covariance @ (W_b.T @ (y / sigma**2))
        return len(values), len(y), f"{100 * np.linalg.norm(y - W_b @ values) / np.linalg.norm(y):.2f}"

    return run


WINDOW, STEP = 0.5, 0.002
"""s: length of the rollouts that are fitted, and the horizon that is compared; step of the simulation."""
START = {"armature": 1.0, "damping": 5.0, "frictionloss": 5.0}
BOUNDS = {"armature": (0.0, 20.0), "damping": (0.0, 100.0), "frictionloss": (0.0, 100.0)}
"""Each joint's [kg m^2, N·m·s, N·m]."""


class StoppedError(Exception):
    """The CPU time is used up."""


def mujoco(arguments: argparse.Namespace) -> None:
    """Identify the UR10e by both, judge both on the recording held out."""
    from mujoco import sysid

    if not hasattr(sysid, "optimize"):
        raise ImportError("MuJoCo without its extra sysid")
    data, robot = recordings_folder("mujoco"), load_robot("ur10e")
    if data is None:
        return
    files = [str(data / "ur10e" / f"{name}.csv.gz") for name in ("unloaded", "validation_unloaded")]
    recordings = [read_recording(file, robot, UR10E_GAINS) for file in files]
    with tempfile.TemporaryDirectory() as name:
        document, model, theirs = (str(Path(name) / file) for file in ("robot.json", "dynident.xml", "sysid.xml"))
        gains, begun = ",".join(map(str, UR10E_GAINS)), time.process_time()
        with contextlib.redirect_stdout(io.StringIO()):
            arm, out = ["--robot", "ur10e"], ["--robot-parameters", document, "--out", model]
            main_of(["identify", *arm, "--data", files[0], "--drive-gains", gains, "--json", document])
            main_of(["robot", "export", "--to", "mjcf", *arm, *out])
        cpu = time.process_time() - begun
        start, motion = start_model(model, robot), measurement(recordings[0], robot.processing)
        found, spent, words = fitted(arguments, start, motion)
        found.compile()
        Path(theirs).write_text(str(found.to_xml()), encoding="utf-8")
        values = results.read_stored_robot(document).possible_values
        arms = {path: mujoco_arm(path, robot) for path in (model, theirs)}
        (rollout,) = roll_out_all(robot, values, recordings[1:], horizons=(WINDOW,), others=arms)
        spreads = [rollout.working.spread(path, WINDOW) for path in arms]
        degrees = [np.degrees(spread.median) for spread in spreads if spread is not None]
    rows = [
        [f"rollout after {WINDOW:g} s [deg]", f"<= 1.1 x {degrees[1]:.2f}", f"{degrees[0]:.2f}"],
        ["CPU time [s]", f"<= {spent:.1f} / 50", f"{cpu:.1f}"],
    ]
    show(f"Real UR10e, asked by mujoco.sysid ({words})", rows)


def start_model(path: str, robot: Robot) -> Any:
    """The exported kinematics with links and drives as a user might guess them; nothing identified is left."""
    import mujoco

    spec = mujoco.MjSpec.from_file(path)
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


def fitted(arguments: argparse.Namespace, spec: Any, data: Measurement) -> tuple[Any, float, str]:
    """The model that ``mujoco.sysid`` finds, its CPU time [s], and how the search went."""
    from mujoco import __version__, sysid

    spec.option.timestep = STEP
    model = spec.compile()
    best = sysid.ParameterDict()
    for number in range(1, model.nv + 1):

        def write_body(changed: Any, parameter: Any, link: str = f"link{number}") -> None:
            numbers = sysid.model_modifier.pi_from_theta(parameter.value)
            mass, moments, about_origin = numbers[0], numbers[1:4], numbers[4:].reshape(3, 3)
            com = moments / mass
            about_com = about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))
            set_body(changed.body(link), mass, com, about_com)

        # Its own modifier compiles the model once a link: this one costs it nothing.
        kind = sysid.InertiaType.Pseudo
        best.add(sysid.body_inertia_param(spec.copy(), model, f"link{number}", kind, modifier=write_body))
    for joint in spec.joints:
        for name, (low, high) in BOUNDS.items():

            def write(changed: Any, parameter: Any, joint: str = joint.name, name: str = name) -> None:
                set_drive(changed.joint(joint), name, float(parameter.value[0]))

            best.add(sysid.Parameter(f"{joint.name} {name}", START[name], low, high, modifier=write))
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

    def difference(_: Any, __: Any, measured: Any, model: Any, ___: bool, state: Array) -> tuple[Array, Any, Any]:
        # Positions [rad]: its own are shares of the path, however little a joint moves.
        predicted = [np.interp(measured.times[1:], state[:, 0], q) for q in state[:, 1 : model.nq + 1].T]
        return measured.data[1:] - np.column_stack(predicted), measured, measured

    residual = sysid.build_residual_fn(models_sequences=[sequences], n_threads=1, modify_residual=difference)
    before, passed = time.process_time(), [best.as_vector()]

    def watched(log: list[Any]) -> None:
        passed.append(np.ravel(log[-1].candidate).copy())
        if time.process_time() - before > arguments.cpu:
            raise StoppedError

    end = "ended"
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            best, _ = sysid.optimize(best, residual, "mujoco", verbose=False, x_scale="jac", iter_callback=watched)
    except StoppedError:
        end = "stopped, not ended"
        best.update_from_vector(passed[-1])
    words = f"{__version__}, {arguments.rollouts} rollouts, {len(passed) - 1} iterations, {end}"
    return sysid.apply_param_modifiers_spec(best, spec.copy()), time.process_time() - before, words


def searches(_: argparse.Namespace) -> None:
    """Condition numbers of motions that black-box searches find, median and worst of five seeds."""
    import cma

    problem = build_design(load_robot("rx90"), ViaPointShape(14, passing=False), Goal("cond"))
    family = problem.family

    def value(x: Array) -> float:
        state = problem.state(x, 0.01)  # rad/s: of the smoothed sign
        weights = problem.row_weights(state.samples, problem.criterion.weighted)
        gram = problem.kernel.gram(state.entries, weights)[np.ix_(problem.places, problem.places)]
        return float(problem.criterion(gram, 200.0)[0])  # order of the surrogate: as good as exact

    def violation(x: Array) -> float:
        state = problem.state(x, 0.0)
        return max(float(excess(limit, limit.values(state)).max()) for limit in problem.limits)

    def random_search(seconds: float, seed: int) -> float:
        draw, best, end = np.random.default_rng(seed), np.inf, time.process_time() + seconds
        while time.process_time() < end:
            rival = random_motion(problem, "14 points at rest", draw)
            best = best if rival is None else min(best, value(rival.x))
        return best

    def cma_es(seconds: float, seed: int) -> float:
        """The best feasible one; violations are penalised (exact penalty)."""
        (start,), end = random_motions(problem, "14 points at rest", 1, seed), time.process_time() + seconds
        bounds, best = {"bounds": [family.low, family.high], "tolfun": 0.0, "tolx": 0.0}, value(start.x)
        search = cma.CMAEvolutionStrategy(start.x, 0.1, {"seed": seed + 1, "verbose": -9, **bounds})
        while time.process_time() < end:
            candidates, costs = search.ask(), []
            for x in candidates:
                missed, own = violation(x), value(x)
                best = min(best, own) if missed <= 0.0 else best
                costs.append(own + 10.0 * max(missed, 0.0))
            search.tell(candidates, costs)
        return best

    designs = [solve_design(problem, seed=seed) for seed in range(5)]
    found = {
        "this package": [design.score.value for design in designs],
        "random search": [random_search(design.cpu_s, seed) for seed, design in enumerate(designs)],
        "CMA-ES": [cma_es(design.cpu_s, seed) for seed, design in enumerate(designs)],
        "CMA-ES, four times as long": [cma_es(4.0 * design.cpu_s, seed) for seed, design in enumerate(designs)],
    }
    rows = [[name, f"{np.exp(np.median(logs)):.1f}", f"{np.exp(max(logs)):.1f}"] for name, logs in found.items()]
    show("RX90, 14 via points at rest, equal CPU time: cond, median of five seeds", rows, "worst", asked=False)


def main() -> None:
    peers = {
        "figaroh": (figaroh, "figaroh==1.0.2"),
        "mujoco": (mujoco, "'mujoco[sysid]'"),
        "searches": (searches, "cma"),
    }
    arguments = options(__doc__, peers=tuple(peers), rounds=5, rollouts=60, cpu=240.0)
    for name in arguments.peers:
        run, package = peers[name]
        try:
            run(arguments)
        except ImportError as missing:
            print(f"{name}: left out, not installed ({missing}): pip install {package}")


if __name__ == "__main__":
    main()
