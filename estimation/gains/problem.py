"""The problem of drive gains, currents without and with known weights, reduced; its solutions, free and possible.

Gains of a robot and a payload that can exist are the same least squares over possible bodies, solved as cones. The
equations are homogeneous: torques and gains may be scaled together. The gain that is known best is therefore held
while the linearised problem, a cone program, is solved; the load's known mass sets the scale at the end.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.linear import least_squares
from ...common.progress import Progress, silent
from ...model import INERTIAL, BaseParameters, Processing, Recording, Robot, standard_columns, standard_regressor
from ...model.base.rank import random_states
from ...model.drives import SPRING, parameter_kind
from ...model.kernel.kernel import Kernel
from ..equations.equations import PAYLOAD, Equations, merged, triangular
from ..equations.leave_one_out import each
from ..fit.drive_gains import Fingerprints, fingerprints
from ..payload.long_motion import payload_problem, with_friction
from ..payload.problem import PayloadProblem, Source
from ..payload.result import in_payload_frame
from ..possible.cone import ConeProgram, SolverError, solve_in_turn
from ..possible.robot import POWERS, DriveRules, link_indices, typical_length
from .current_side import CurrentFit, current_weights, gauss_newton
from .known_load import KnownLoad, Mountings, known_mass, known_values, payload_columns

_SHOWN = 0.05  # of a joint's squared residual: what a payload that is there takes off at least
_USUAL = 10.0  # N·m/A: the size of an arm's gains, so that checks of torques see torques; divided out again


@dataclass(frozen=True)
class GainProblem:
    """Equations i_j = k_j (W_j chi + W_Lj chi_L) + rho_j, motor by motor, k_j = 1 / K_j.

    Of coupled drives W_j are the rows of the motors on the joint side; a known spring is a column of W whose
    parameter is 1.

    Attributes:
        robot: the robot, its equations those of the motors (``Robot.for_currents``).
        description: as it was given, its equations those of the joints.
        equations: the factors of [W W_L i], columns base, then ``payload_columns`` of each mounting; the right-hand
            side is a current [A].
        weights: per joint, one over the standard deviation of its current's error [1/A].
        deletions: the equations without each block of time, for the jackknife; one tuple a group.
        block_length: of those blocks [s]; 0 where there are none.
        without_blocks: why there are none.
        recordings: by which later recordings are known for the same.
        mountings: which recordings have the weight where.
        source: the recordings of currents, in which causes are looked for.
        posed: each mounting's payload problem, its torques those that the gains ``posed_with`` give; what the
            verdict looks at.
    """

    robot: Robot
    description: Robot
    base: BaseParameters
    equations: Equations
    weights: Array
    deletions: tuple[tuple[Equations, ...], ...] = ()
    block_length: float = 0.0
    without_blocks: str = ""
    recordings: Fingerprints = field(default_factory=dict)
    mountings: Mountings = Mountings()
    source: Source | None = None
    posed: tuple[PayloadProblem, ...] = ()
    posed_with: tuple[float, ...] = ()

    def posed_by(self, K: Array) -> tuple[PayloadProblem, ...]:
        """Each mounting's payload problem with torques that gains K give."""
        ratio, posed = K / np.array(self.posed_with) if self.posed else K, []
        for problem in self.posed:
            source = problem.source
            assert source is not None
            loaded, unloaded = (
                tuple(_scaled(self.robot, group, ratio, joints=True)) for group in (source.loaded, source.unloaded)
            )
            rescaled = replace(
                problem,
                loaded=_times(problem.loaded, ratio),
                unloaded=_times(problem.unloaded, ratio) if problem.unloaded else None,
                difference=_times(problem.difference, ratio) if problem.difference else None,
                stretches=tuple(_times(stretch, ratio) for stretch in problem.stretches),
                source=source._replace(loaded=loaded, unloaded=unloaded),
            )
            posed.append(with_friction(rescaled))
        return tuple(posed)


def gain_problem(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    processing: Processing | None = None,
    progress: Progress = silent,
    load: KnownLoad | Sequence[KnownLoad] | None = None,
    mounting: Sequence[int] = (),
) -> GainProblem:
    """Process recordings of currents and reduce them.

    Args:
        unloaded: recordings without payload whose ``torque`` holds motor currents [A].
        loaded: the same with the known weight or weights.
        processing: settings; the robot's own by default.
        load: the known payload, or that of each mounting; needed by arms with a spring alone, whose known torque
            has a scale as well.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass. All one
            by default.

    Raises:
        InputError: if the recordings cannot be used, or there are not as many numbers as loaded recordings.
    """
    description, robot = robot, robot.for_currents()
    if not unloaded:
        raise InputError("drive gains need recordings without and with the payload: give both")
    mountings = Mountings.of(mounting, len(loaded), len(unloaded))
    usual = np.full(robot.n, _USUAL)
    first = _posed(robot, unloaded, loaded, mountings, usual, processing, progress)
    both = _times(_together(first, mountings), 1.0 / usual)
    weights = current_weights(both)
    # How long residuals remember shows only once the joints' torques are to scale; all of them by one factor is
    # enough.
    try:
        K = 1.0 / free_gains(both, weights, mountings.loads(load or known_mass(1.0))).k
        K *= _USUAL / K.mean()
    except NoGainsError:  # told when the gains are asked for
        K = usual
    posed = _posed(robot, unloaded, loaded, mountings, K, processing, progress, robust=True)
    return GainProblem(
        robot,
        description,
        first[0].base,
        both,
        weights,
        *_without_blocks(posed, mountings, K),
        fingerprints(unloaded, loaded),
        mountings,
        Source(tuple(loaded), tuple(unloaded), processing or robot.processing),
        posed,
        tuple(K.tolist()),
    )


class NoGainsError(InputError):
    """The currents give no gains, or such as cannot be."""


def free_gains(equations: Equations, weights: Array, loads: Sequence[KnownLoad]) -> CurrentFit:
    """Gains, base parameters and what is unknown of the payload, without constraints.

    Raises:
        NoGainsError: if the recordings leave a gain undetermined, or one is negative.
    """
    values = known_values(loads) | {name: 1.0 for name in equations.columns if parameter_kind(name) == SPRING}
    free = [k for k, name in enumerate(equations.columns) if name not in values]
    known = np.array([values.get(name, 0.0) for name in equations.columns])
    # Where the payload is there, it explains some joint's current, seen alone, better.
    base = [k for k, name in enumerate(equations.columns) if "_L" not in name]
    for factor in equations.factors:
        W, current = factor[:, :-1], factor[:, -1]
        less, more = (float(np.sum((current - A @ least_squares(A, current)) ** 2)) for A in (W[:, base], W))
        if less - more > _SHOWN * less:
            break
    else:
        raise NoGainsError("the payload does not show in the currents: is it in the loaded recording?")
    try:
        fitted = gauss_newton(equations, weights, free, known)
    except InputError as error:
        raise NoGainsError(str(error)) from None
    negative = [str(j) for j, k in enumerate(fitted.k, 1) if k <= 0.0]
    if not negative:
        return fitted
    friction = zip(equations.columns, fitted.x, strict=True)
    brakes = sum(np.sign(value) for name, value in friction if parameter_kind(name) == "FS")
    if len(negative) == len(fitted.k) and brakes < 0:  # Coulomb friction that drives more joints than it brakes
        raise NoGainsError(
            "the recordings with and without the payload look exchanged: the known weight comes out negative; "
            "exchange --loaded and --unloaded"
        )
    raise NoGainsError(
        f"the current of motor {', '.join(negative)} pushes against its motion: turn its sign (--signs, or sign "
        "in a log map), or check the order of joints"
    )


def _posed(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    mountings: Mountings,
    K: Array,
    processing: Processing | None,
    progress: Progress,
    robust: bool = False,
) -> tuple[PayloadProblem, ...]:
    """The payload problem of each mounting, with joint torques that gains K would give."""
    bare, heavy = (list(_scaled(robot, group, K)) for group in (unloaded, loaded))
    return tuple(
        payload_problem(
            robot,
            [heavy[k] for k in places],
            [bare[k] for k in (places if mountings.paired else range(len(bare)))],
            None,
            processing,
            progress,
            robust=robust,
        )
        for places in mountings.places
    )


def _together(problems: Sequence[PayloadProblem], mountings: Mountings) -> Equations:
    """The equations of all mountings, each with the payload's columns of its own; each recording once."""
    payloads = payload_columns(len(problems))
    columns = (*problems[0].base.columns, *(name for names in payloads for name in names))
    everything = []
    for k, (problem, names) in enumerate(zip(problems, payloads, strict=True)):
        part = problem.both if mountings.paired or k == 0 else problem.loaded
        part = in_payload_frame(problem.robot, part)
        named = part.transformed((*problem.base.columns, *names), np.eye(len(part.columns)))
        everything.append(named.among(columns))
    return replace(merged(everything), leave_one_out=())


def _scaled(
    robot: Robot, recordings: Sequence[Recording], ratio: Array, joints: bool = False
) -> Iterator[Recording]:
    """The recordings' motor currents, or torques of ``joints``, times ``ratio`` of each motor, as joint torques."""
    coupling = robot.coupling
    for recording in recordings:
        motors = coupling.motor_torques(recording.torque) if joints and coupling else recording.torque
        torque = motors * ratio
        yield replace(recording, torque=coupling.joint_torques(torque) if coupling else torque)


def _times(equations: Equations, ratio: Array) -> Equations:
    """Right-hand sides of joint j times ``ratio[j]``."""
    factors = [
        factor * np.append(np.ones(factor.shape[1] - 1), joint_ratio)
        for factor, joint_ratio in zip(equations.factors, ratio, strict=True)
    ]
    cut = each(equations.leave_one_out, lambda part: _times(part, ratio))
    return replace(equations, factors=tuple(factors), leave_one_out=cut)


def _without_blocks(
    problems: Sequence[PayloadProblem], mountings: Mountings, K: Array
) -> tuple[tuple[tuple[Equations, ...], ...], float, str]:
    """The currents without each block, groups of them; the blocks' length; else why there are none."""
    groups = []
    try:
        for k, problem in enumerate(problems):
            # Recordings without payload that all mountings share are left out once.
            own = problem.without_blocks if mountings.paired or k == 0 else problem.without_blocks[:1]
            groups += [
                tuple(
                    _times(_together([*problems[:k], part, *problems[k + 1 :]], mountings), 1.0 / K)
                    for part in group
                )
                for group in own
            ]
    except InputError as error:
        return (), 0.0, str(error)
    return tuple(groups), max(problem.loaded.block_length for problem in problems), ""


def gravity_acts(robot: Robot) -> tuple[bool, ...]:
    """Per motor, whether some mass of the robot or payload weighs on it in some pose."""
    q, qd, _ = random_states(robot, 20, seed=0)
    kernel = Kernel(standard_regressor(robot))
    entries = kernel(q, 0.0 * qd, 0.0 * qd)
    heavy = [parameter_kind(name) in ("MX", "MY", "MZ", "M") for name in standard_columns(robot)]
    weights = np.zeros((len(heavy), 20, robot.n))
    for row, column, values in zip(kernel.rows, kernel.columns, entries, strict=True):
        weights[column, :, row] = values
    flat = weights[heavy].reshape(-1, robot.n)
    motors = robot.coupling.motor_torques(flat) if robot.coupling else flat
    return tuple(bool(weight > 1e-9) for weight in np.abs(motors).max(axis=0))


def rests_on(robot: Robot) -> tuple[str, ...]:
    """Per motor, in words, which torques its gain rests on."""
    words = [
        "gravity and inertia" if gravity else "inertia only: no gravity acts on this joint"
        for gravity in gravity_acts(robot)
    ]
    if robot.spring is not None:
        words[robot.spring.joint - 1] += ", and the known spring"
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        words[j - 1] += f" (the torque of joint {j} less that of joint {k})"
        words[k - 1] += f" (motor {k} turns with joints {j} and {k})"
    return tuple(words)


_MOST = 50  # linearisations
_ENOUGH = 1e-5  # relative change of a gain
_WAYS = ((1e5, np.inf), (1e5, 1e3), (1e5, 1e2), (1e3, 1e2), (1e2, 1e2), (1e2, 30.0))
"""Largest entry, and radius of the scaled unknowns: what no current shows has no least value, and may run away."""
_LENGTH = 0.1  # m: size of a payload, for scaling only


def possible_gains(
    problem: GainProblem, equations: Equations, loads: Sequence[KnownLoad], start: CurrentFit, anchor: int
) -> CurrentFit:
    """Gains, base parameters and payload of bodies that can exist, drives that do not push.

    Args:
        problem: robot and weights.
        equations: all of the problem's or those without a block.
        loads: what is known of the payload in each mounting.
        start: gains to begin with, whose covariance is kept.
        anchor: place of the gain that stays while solving.

    Raises:
        InputError: if the gains do not settle or no bodies explain the currents.
    """
    to_x, to_bodies, rules = _variables(problem, loads, start.x)
    k, x, n, m = start.k.copy(), start.x.copy(), len(start.k), to_x.shape[1]
    keep = [*range(m), *(m + j for j in range(n) if j != anchor)]
    A = np.zeros((len(rules) + n - 1, len(keep)))
    A[: len(rules), :m], A[len(rules) :, m:] = rules, np.eye(n - 1)
    bodies = np.zeros((*to_bodies.shape[:2], len(keep)))
    bodies[:, :, :m] = to_bodies
    for _ in range(_MOST):
        # The linearised currents: columns z, then k over its present value for each joint, then the right side.
        rows = []
        for j, (factor, w) in enumerate(zip(equations.factors, problem.weights, strict=True)):
            current = k[j] * factor[:, :-1] @ x
            own = np.zeros((len(factor), n))
            own[:, j] = current if j != anchor else 0.0
            right = factor[:, -1] + (current if j != anchor else 0.0)
            rows.append(w * np.column_stack([k[j] * factor[:, :-1] @ to_x, own, right]))
        top = triangular(np.vstack(rows))[: m + n]  # below it stands what no unknown explains
        try:
            solution = solve_in_turn(ConeProgram(top[:, keep], top[:, -1], A, np.zeros(len(A)), bodies), _WAYS)
        except SolverError as error:
            raise InputError(f"gains of bodies that can exist were not found ({error.words})") from None
        ratio = np.insert(solution.z[m:], anchor, 1.0)
        share = float(solution.z[m - 1])  # of the load
        if share <= 0.0 or (ratio <= 0.0).any():
            raise InputError("no gain explains the currents: check units, signs, order of joints and the payload")
        x = to_x @ solution.z[:m] / share
        ratio *= share
        k = k * ratio
        if np.abs(ratio - 1.0).max() < _ENOUGH:
            return start._replace(k=k, x=x)
    raise InputError(
        "the gains of bodies that can exist do not settle: check units, signs and order of the currents"
    )


def _variables(problem: GainProblem, loads: Sequence[KnownLoad], x: Array) -> tuple[Array, Array, Array]:
    """Maps of the cone program's z to the base parameters and the payload's ten, c x m, and to bodies, p x 10 x m.

    z are standard parameters of the robot, what is unknown of the payload, and the share of what is known, scaled;
    last the rows A z that must not be negative.
    """
    base, length = problem.base, typical_length(problem.robot)
    free = [(k, name) for k, load in enumerate(loads) for name in load.free]
    known = [parameter_kind(name) == SPRING for name in base.standard]
    names = [name for name, fixed in zip(base.standard, known, strict=True) if not fixed]
    standard = len(names)
    m = standard + len(free) + 1
    scale = np.ones(m)
    # One mass and one length for all links, one size for friction.
    own = dict(zip(base.columns, np.abs(x), strict=False))
    masses = [v / length ** POWERS[parameter_kind(k)] for k, v in own.items() if parameter_kind(k) in INERTIAL]
    others = [v for k, v in own.items() if k in names and parameter_kind(k) not in POWERS]
    mass, friction = float(np.median(masses)) or 1.0, max(float(np.median(others or [1.0])), 1e-6)
    kinds = [parameter_kind(name) for name in names]
    scale[:standard] = [mass * length ** POWERS[kind] if kind in POWERS else friction for kind in kinds]
    scale[standard:-1] = [loads[k].mass * _LENGTH ** POWERS[name.removesuffix("_L")] for k, name in free]
    to_x = np.zeros((len(base.columns) + len(loads) * len(PAYLOAD), m))
    to_x[: len(base.columns), :standard] = base.grouping[:, np.logical_not(known)]
    to_x[: len(base.columns), -1] = base.grouping[:, known].sum(axis=1)  # a spring's torque: its parameter is 1
    weights = np.zeros((len(loads), len(PAYLOAD), m))
    for place, (k, name) in enumerate(free, standard):
        weights[k, PAYLOAD.index(name), place] = 1.0
    weights[:, :, -1] = [load.ten for load in loads]
    to_x[len(base.columns) :] = weights.reshape(-1, m)
    links = np.eye(standard, m)[link_indices(problem.robot, names)]
    rules = DriveRules.of(problem.robot, names, scale[:standard]).A
    A = np.zeros((len(rules) + 1, m))
    A[:-1, :standard] = rules
    A[-1, -1] = 1.0
    # A body whose ten are all known needs no cone: it was checked when it was read.
    open_ones = [body for body, load in zip(weights, loads, strict=True) if load.free]
    bodies = np.array([*links, *open_ones]) * scale
    return to_x * scale, bodies, A
