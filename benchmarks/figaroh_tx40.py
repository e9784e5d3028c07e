"""Drives FIGAROH 1.0.2 on the TX40 recording, in the two ways of its examples; for against_figaroh.py."""

import json
import math
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from dynident.common.arrays import Array
from dynident.model import Recording, Robot
from scipy.signal import decimate

try:
    import pinocchio as pin
    from figaroh.identification import identification_tools as tools
    from figaroh.identification.base_identification import BaseIdentification
    from figaroh.identification.parameter import add_standard_additional_parameters, get_standard_parameters
    from figaroh.tools import regressor as regressors
    from figaroh.tools.qrdecomposition import QRDecomposer, get_baseParams
    from figaroh.tools.robot import Robot as FigarohRobot
except ImportError as missing:
    print(f"FIGAROH does not import ({missing}): pip install figaroh==1.0.2", file=sys.stderr)
    sys.exit(2)

CUTOFF, DECIMATE, ORDER = 100.0, 10, 4
"""FIGAROH's: Butterworth cut-off [Hz] and order, factor of decimation."""
EDGE = 5 * ORDER
"""Samples that its examples cut from both ends."""
RANDOM_STATES, RANGES = 50_000, (6.0, 10.0, 30.0)
"""Of its script, for q [rad], qd, qdd."""
TINY = 1e-6, 1e-3
"""Columns below are left out of random states, of the recording: its script's."""


class Answer(NamedTuple):
    """What one run came to: numbers of base parameters and equations, relative residual."""

    parameters: int
    equations: int
    residual: float


class Tx40(BaseIdentification):  # type: ignore[misc]
    """FIGAROH's identification of the TX40, as its later example writes it."""

    def __init__(self, robot: Any, config: Path, recording: Recording) -> None:
        """Name the joints and set the filter."""
        super().__init__(robot, str(config))
        self.recording = recording
        every = list(range(robot.model.nv))
        self.identif_config |= {"act_idxq": every, "act_idxv": every, "act_Jid": [j + 1 for j in every]}
        filtering = {"nbutter": ORDER, "f_butter": CUTOFF, "f_sample": 1 / self.identif_config["ts"]}
        self.filter_config = {"differentiation_method": "gradient", "filter_params": filtering}

    def load_trajectory_data(self, data_source: str | None = None) -> dict[str, Array | None]:
        """Positions and torques on the side of the joints, from memory."""
        data = {"timestamps": self.recording.t, "positions": self.recording.q, "torques": self.recording.torque}
        return {**data, "velocities": None, "accelerations": None}

    def process_torque_data(self, **_: Any) -> Array:
        """Cut what the filter spoils off both ends of all signals."""
        for name, signal in self.processed_data.items():
            self.processed_data[name] = signal[EDGE:-EDGE]
        return np.asarray(self.raw_data["torques"][EDGE:-EDGE])


class Bare(Tx40):
    """The estimation alone: no validation on the same data, no provenance, no report."""

    def _store_results(self, identif_results: dict[str, Any]) -> None:
        self.result = identif_results

    def print_quality_report(self) -> None:
        """Print nothing."""


def by_class(problem: Any) -> Answer:
    """Initialize and solve."""
    problem.initialize()
    problem.solve(decimate=True, decimation_factor=DECIMATE, wls=True, plotting=False)
    error = np.linalg.norm(problem.tau_noised - problem.tau_identif) / np.linalg.norm(problem.tau_noised)
    return Answer(len(problem.result["wls_std_deviations"]), len(problem.tau_noised), float(error))


def by_functions(problem: Any, slow_fraction: float, structural: bool = True) -> Answer:
    """What the script does: structural base parameters, then those that the recording shows."""
    robot, settings, recording = problem.robot, problem.identif_config, problem.recording
    standard = get_standard_parameters(robot.model, settings)
    standard |= add_standard_additional_parameters(robot.model, settings)
    standard |= dict.fromkeys(("Iam6", "fvm6", "fsm6"), 0.0)
    if structural:
        structural_base(robot, settings, standard)
    q = tools.low_pass_filter_data(recording.q, settings, ORDER)
    q, qd, qdd = tools.calculate_first_second_order_differentiation(robot.model, q, settings)
    W = coupled_regressor(robot, settings, q, qd, qdd).reshape(robot.nv, len(q), -1)
    Y = recording.torque[EDGE : EDGE + len(q)]
    rows, torques = [], []
    for j in range(robot.nv):
        column = twice_decimated(Y[:, j])
        wide = np.column_stack([twice_decimated(w) for w in W[j].T])
        speed = np.abs(wide[:, list(standard).index(f"fv_joint{j + 1}")])
        keep = speed >= slow_fraction * speed.max()
        rows.append(wide[keep])
        torques.append(column[keep])
    W_e, names = regressors.eliminate_non_dynaffect(np.vstack(rows), standard, TINY[1])
    Y_all = np.concatenate(torques)
    W_b, _, _, values = QRDecomposer().double_decomposition(Y_all, W_e, names)
    return weighted(W_b, Y_all, values, np.cumsum([len(y) for y in torques])[:-1])


def structural_base(robot: Any, settings: dict[str, Any], standard: dict[str, float]) -> None:
    """Base parameters from random states."""
    draw = np.random.default_rng(0)
    W = coupled_regressor(robot, settings, *(draw.uniform(-x, x, (RANDOM_STATES, robot.nv)) for x in RANGES))
    absent, names = regressors.get_index_eliminate(W, standard, TINY[0])
    get_baseParams(regressors.build_regressor_reduced(W, absent), names, standard)


def weighted(W: Array, Y: Array, values: Array, ends: Array) -> Answer:
    """The script's last step: each joint's rows over their error's norm; FIGAROH has it in its class alone."""
    error = [np.full(len(part), np.sqrt(np.mean(part**2))) for part in np.split(Y - W @ values, ends)]
    sigma = np.concatenate(error)
    covariance = np.linalg.inv((W / sigma[:, None]).T @ (W / sigma[:, None]))
    values = covariance @ (W.T @ (Y / sigma**2))
    deviations = np.sqrt(np.diag(covariance))
    return Answer(len(deviations), len(Y), float(np.linalg.norm(Y - W @ values) / np.linalg.norm(Y)))


def coupled_regressor(robot: Any, settings: dict[str, Any], q: Array, qd: Array, qdd: Array) -> Array:
    """FIGAROH's regressor, joint by joint, and three columns for rotor 6."""
    columns = np.zeros((robot.nv, len(q), 3))
    sign = np.sign(qd[:, 4] + qd[:, 5])
    for row, partner in ((4, 5), (5, 4)):
        columns[row] = np.column_stack([qdd[:, partner], qd[:, partner], sign])
    W = regressors.build_regressor_basic(robot, q, qd, qdd, settings)
    return np.hstack([W, columns.reshape(-1, 3)])


def twice_decimated(signal: Array) -> Array:
    """By 10, then by 10 again."""
    for _ in range(2):
        signal = decimate(signal, DECIMATE, zero_phase=True)
    return signal


def urdf(robot: Robot) -> str:
    """The robot's geometry as URDF; the bodies' numbers play no part in a regressor."""
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
    return f'<robot name="{robot.name}">{"".join(parts)}</robot>'


def configuration(robot: Robot, recording: Recording) -> str:
    """FIGAROH's configuration file (JSON is YAML)."""
    rate = (len(recording.t) - 1) / float(recording.t[-1] - recording.t[0])
    components = dict.fromkeys(("friction", "joint_offset", "actuator_inertia"), True)
    task = {
        "problem": {"use_joint_torques": True, "wls": True, "model_components": components},
        "signal_processing": {"sampling_frequency": rate, "cutoff_frequency": CUTOFF, "filter_order": ORDER},
    }
    joints = {"active_joints": [f"joint{j}" for j in range(1, robot.n + 1)]}
    properties = {"joints": joints, "coupling": {"has_coupled_wrist": True}}
    return json.dumps({"robot": {"name": robot.name, "properties": properties}, "tasks": {"identification": task}})


def prepared(kind: type[Tx40], robot: Robot, recording: Recording) -> Tx40:
    """FIGAROH's problem, its robot loaded and its configuration read."""
    with tempfile.TemporaryDirectory() as name:
        model, settings = Path(name) / "robot.urdf", Path(name) / "robot.yaml"
        model.write_text(urdf(robot), encoding="utf-8")
        settings.write_text(configuration(robot, recording), encoding="utf-8")
        return kind(FigarohRobot(str(model), name), settings, recording)
