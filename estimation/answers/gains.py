"""Drive gains, torque per motor current, from recordings of currents without and with known weights.

Least squares on the currents, i_j = k_j (W_j x) + rho_j, over k and x, by Gauss-Newton. The errors are in the
currents: fitting torques, K_j i_j = W_j x, has them in a regressor's place and gives gains that are too small (on a
UR10e by 10 % and more); it serves as the start only (its linear system is that of Gautier and Briot, Global
identification of joint drive gains and dynamic parameters of robots, 2014).

Gains of a robot and a payload that can exist are the same least squares over possible bodies, as cones. The
equations are homogeneous, torques and gains may be scaled together: the gain that is known best is therefore fixed
while the linearised problem is solved; the load's known mass sets the scale at the end.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from msgspec import UNSET
from scipy.linalg import block_diag

from ...common import Array, Brief, InputError, decomposed, one_thread
from ...common.schema import Real, WrongKeyError
from ...model import INERTIAL, InertialParameters, Recording, Robot, standard_columns
from ...model.base import random_states
from ...model.drives import SPRING, parameter_kind
from ...model.files.robot_file import BodyTable
from ...model.regressors import regressor_at
from ..diagnosis.causes import likely_causes
from ..diagnosis.engine import states_of
from ..diagnosis.evidence import KNOWN_WELL
from ..diagnosis.verdict import diagnose, judge
from ..equations.equations import PAYLOAD, Equations, check_blocks, merged, triangular
from ..fit.covariance import NORMAL95, jackknife
from ..fit.estimate import Fit, fingerprints
from ..fit.settings import DEFAULTS, Candidates, Settings
from ..payload.by_joints import ByJoints
from ..payload.long_motion import LongMotion, Source, in_payload_frame, payload_problem
from ..payload.methods import payload_estimate
from ..possible.constraints import ConeProgram, SolverError, solve_cone
from ..possible.robot import POWERS, drive_rules, link_indices, typical_length
from ..results.parts import ProcessingDocument, ResidualDocument, RobustDocument
from ..results.payload import TorquePrediction, named
from ..results.robot import GainsResult, GainsTable, LoadDocument, MountingDocument
from ..signals.recordings import check_given, without_dead
from .identification import DRAWN, payload_predictions

_SHOWN = 0.05  # of a joint's squared residual: what a payload that is there takes off at least
_USUAL = 10.0  # N·m/A: the size of an arm's gains, so that checks of torques see torques; divided out again
_MOST = 200  # iterations
_LONGEST = 0.5  # step of a gain, relative
_ENOUGH = 1e-9  # relative change of a gain
_ROUNDS = 3  # of weights for the start
_SPREAD = 10.0  # of gains about their median, as far as weights go
_FLOOR = 1e-9  # of the current: data without noise still need finite weights
_LINEARISED = 50  # cone programs
_CLOSE = 1e-5  # relative change of a gain
_WAYS = ((1e5, np.inf), (1e5, 1e3), (1e5, 1e2), (1e3, 1e2), (1e2, 1e2), (1e2, 30.0))
"""Bounds on the scaled unknowns, entry and radius: what no current shows has no least value, and may run away."""
_LENGTH = 0.1  # m: size of a payload, for scaling only


class CurrentFit(NamedTuple):
    """Gains and parameters, free or of bodies that can exist."""

    k: Array  # A/(N·m), shape (n,)
    x: Array  # all parameters, shape (c,)
    covariance: Array  # of ln K by the free fit, n x n, for white noise
    weights: Array  # of the joints [1/A], shape (n,)


def gauss_newton(equations: Equations, weights: Array, free: Sequence[int], known: Array) -> CurrentFit:
    """Minimise sum_j w_j^2 ||i_j - k_j W_j x||^2.

    ``free``: indices of the unknown parameters; ``known``: the others' values, which set the scale, shape (c,).
    """
    c, n, x, size = len(free), len(equations.factors), known.copy(), np.ones(len(equations.factors))
    rows, motor = np.vstack(equations.factors), np.repeat(np.arange(n), [*map(len, equations.factors)])
    for _ in range(1 + _ROUNDS):  # the torque side, K_j i_j = W_j x, is linear in K and x
        sized = size[motor, None] * rows
        A = np.column_stack([sized[:, free], -sized[:, -1:] * np.eye(n)[motor]])
        solution = decomposed(A).solution(-sized[:, :-1] @ known)
        K = solution[c:]
        if not (np.abs(K) > 1e-12 * np.abs(K).max()).all():
            raise InputError("the payload does not show in the currents: is it in the loaded recording?")
        x[free], k = solution[:c], 1.0 / K
        # Each joint weighted by the errors of its torque: a disturbance of the arm's would outweigh the wrist's.
        middle = float(np.median(np.abs(k)))
        size = weights * np.clip(np.abs(k), middle / _SPREAD, middle * _SPREAD)
    step = np.full(c + n, np.inf)
    for _ in range(_MOST):
        J, error = linearised(equations.factors, weights, k, x, free)
        parts = decomposed(J)
        if np.abs(step[c:] / k).max() < _ENOUGH:
            break
        if parts.null.size:  # the gains stand last
            missing = np.abs(parts.null[c:]).max(axis=1)
            joints = [str(j) for j, weight in enumerate(missing, 1) if weight > 1e-3]
            unknown = f"the gain of joint {', '.join(joints)}" if joints else "the robot's parameters"
            advice = "move more joints, faster and over a wider range"
            raise InputError(f"the recordings do not determine {unknown}: {advice}")
        step = parts.solution(error)
        step *= min(1.0, _LONGEST / np.abs(step[c:] / k).max())
        x[free] += step[:c]
        k += step[c:]
    else:
        advice = "check units, signs and order of the currents, and that the arm touched nothing"
        raise InputError(f"the drive gains do not settle: {advice}")
    dof = sum(equations.effective_rows) - J.shape[1]
    if dof <= 0.0:
        raise InputError(f"too few samples for {J.shape[1]} unknowns: record longer")
    root = parts.root[c:] / k[:, None]
    return CurrentFit(k, x, float(error @ error) / dof * root @ root.T, weights)


def linearised(
    factors: Sequence[Array], weights: Array, k: Array, x: Array, free: Sequence[int]
) -> tuple[Array, Array]:
    """Jacobian of the predicted currents by the free x and k, and the currents' errors, both weighted."""
    motor = np.repeat(np.arange(len(k)), [*map(len, factors)])
    rows = weights[motor, None] * np.vstack(factors)
    torques, by_x = rows[:, :-1] @ x, k[motor, None] * rows[:, free]
    return np.column_stack([by_x, torques[:, None] * np.eye(len(k))[motor]]), rows[:, -1] - k[motor] * torques


class KnownLoad(BodyTable, frozen=True, kw_only=True):
    """Known ones of the payload's ten parameters, in the robot's payload frame; also the keys of its TOML file.

    ``com`` [m] holds three numbers, ``inertia_com`` [kg m^2] XX XY XZ YY YZ ZZ at the centre of mass.
    """

    mass: Real  # kg
    mass_sigma: Real = 0.0  # its standard deviation [kg]; the others are known per mass, so that it is one of scale

    def __post_init__(self) -> None:
        """Refuse a load without mass, and an inertia without its centre of mass or of no body."""
        if not 0.0 < self.mass < np.inf:
            raise InputError(f"known mass {self.mass:g} kg: give the payload's mass in kg, more than zero")
        if not 0.0 <= self.mass_sigma < self.mass:
            given = f"standard deviation {self.mass_sigma:g} kg of a mass of {self.mass:g} kg"
            raise InputError(f"{given}: give one of at least 0 and below the mass")
        super().__post_init__()
        if self.inertia_com is None:
            return
        if self.com is None:
            needed = "give the centre of mass [m], three numbers, where inertia_com is given"
            raise WrongKeyError("com", f"missing: {needed}")
        if not self.body().physically_consistent:
            raise WrongKeyError("inertia_com", "no body has this inertia at its centre of mass: correct it")

    @property
    def known(self) -> tuple[str, ...]:
        """Names of ``PAYLOAD`` that are known; ``M_L`` always is."""
        if self.inertia_com is not None:
            return PAYLOAD
        return PAYLOAD[-1:] if self.com is None else PAYLOAD[6:]


def payload_columns(mountings: int) -> tuple[tuple[str, ...], ...]:
    """Names of the payload's ten parameters in each mounting: ``PAYLOAD``, then XX_L2 .. M_L2, and so on."""
    return tuple(tuple(f"{name}{k if k > 1 else ''}" for name in PAYLOAD) for k in range(1, mountings + 1))


def known_values(loads: Sequence[KnownLoad], names: Sequence[str] = ()) -> dict[str, float]:
    """Collect the known parameters of the payload in each mounting by name, and springs among ``names``, 1 each."""
    known = {name: 1.0 for name in names if parameter_kind(name) == SPRING}
    for columns, load in zip(payload_columns(len(loads)), loads, strict=True):
        every = zip(columns, PAYLOAD, load.body().vector.tolist(), strict=True)
        known |= {column: value for column, name, value in every if name in load.known}
    return known


def known_mass(mass: float, sigma: float = 0.0) -> KnownLoad:
    """Make a payload of which only the mass [kg] is known, with its standard deviation [kg]."""
    return KnownLoad(mass=mass, mass_sigma=sigma)


@dataclass(frozen=True, repr=False)
class GainProblem(Brief):
    """Equations i_j = k_j (W_j chi + W_Lj chi_L) + rho_j, motor by motor, k_j = 1 / K_j.

    Of coupled drives W_j are the motors' rows on the joint side; a known spring is a column of parameter 1.
    """

    description: Robot  # as it was given, its equations those of the joints
    equations: Equations  # factors of [W W_L i], columns base, then payload_columns of each mounting; currents [A]
    mountings: tuple[int, ...]  # their numbers
    loads: tuple[KnownLoad, ...]  # what is known of the payload in each
    source: Source  # the recordings of currents, in which causes are looked for
    posed: tuple[LongMotion, ...]  # each mounting's payload problem, which the verdict looks at
    posed_with: tuple[float, ...]  # gains that give its torques
    deletions: tuple[tuple[Equations, ...], ...] = ()  # without each block of time, one tuple a group, or none
    without_blocks: str = ""  # why there are none

    @property
    def robot(self) -> Robot:
        """Robot whose equations are those of the motors (``Robot.for_currents``)."""
        return self.posed[0].robot

    def posed_by(self, K: Array) -> tuple[LongMotion, ...]:
        """Pose each mounting's payload problem with torques that gains K give."""
        ratio, posed = K / np.array(self.posed_with), list[LongMotion]()
        for problem in self.posed:
            loaded, unloaded = (
                tuple(_with_gains(self.robot, one, ratio, currents=False) for one in group)
                for group in problem.source[:2]
            )
            bare, change = (part and _times(part, ratio) for part in (problem.unloaded, problem.difference))
            load, source = _times(problem.loaded, ratio), problem.source._replace(loaded=loaded, unloaded=unloaded)
            posed.append(replace(problem, loaded=load, unloaded=bare, difference=change, source=source))
        return tuple(posed)


def gain_problem(
    robot: Robot,
    unloaded: Sequence[Recording],
    loaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> GainProblem:
    """Process recordings whose ``torque`` holds motor currents [A] and reduce them, as ``identify_gains``.

    Raises:
        InputError: if the recordings cannot be used, or there are not as many numbers as loaded recordings.
    """
    description, robot = robot, robot.for_currents()
    if not unloaded:
        raise InputError("drive gains need recordings without and with the payload: give both")
    if dead := without_dead(robot, [*unloaded, *loaded]).drives.unmeasured:
        joints = ", ".join(map(str, dead))
        raise InputError(f"the current of joint {joints} is one number throughout: the channel is dead; record it")
    if mounting and len(mounting) != len(loaded):
        given = f"{len(mounting)} numbers of mountings for {len(loaded)} loaded recording{'s' * (len(loaded) != 1)}"
        raise InputError(f"{given}: give one number for each of them, in their order, such as 1,2,2 (--mounting)")
    groups: dict[int, list[int]] = {}  # recordings of each mounting's number, which have one centre of mass
    for k, number in enumerate(mounting or [1] * len(loaded)):
        groups.setdefault(number, []).append(k)
    loads = (load,) * len(groups) if isinstance(load, KnownLoad) else tuple(load)
    if len(loads) != len(groups):
        raise InputError(f"{len(loads)} known payloads for {len(groups)} mountings: give one, or one for each")
    if len(groups) > 1 and isinstance(load, KnownLoad) and load.com is not None:
        advice = "omit com and inertia_com, or give one mounting"
        raise InputError(f"several mountings cannot share one centre of mass: {advice}")
    paired = len(loaded) == len(unloaded) or len(groups) < 2  # each loaded recording has its own without payload
    # Friction is not chosen: where no gravity tells a gain, root friction imitates it and makes it look sure.
    asked = settings.friction
    robot = robot if isinstance(asked, Candidates) else robot.with_friction(asked)
    settings, payloads = replace(settings, friction=robot.drives.friction), payload_columns(len(groups))

    def posed(K: Array, robust: bool) -> tuple[tuple[LongMotion, ...], list[Equations]]:
        """Pose each mounting's payload problem, with joint torques that gains K would give.

        Besides, the equations of each in the payload's columns of all; each recording is once in them.
        """
        problems, together = list[LongMotion](), list[Equations]()
        with_load, without = ([_with_gains(robot, one, K) for one in some] for some in (loaded, unloaded))
        for group, names in zip(groups.values(), payloads, strict=True):
            bare = [without[k] for k in group] if paired else without
            asked = replace(settings, robust=robust)
            problem = payload_problem(robot, [with_load[k] for k in group], bare, settings=asked)
            part = problem.loaded if together and not paired else problem.both
            part, base = in_payload_frame(problem.robot, part), problem.base.columns
            part = part.transformed(np.eye(len(part.columns)), (*base, *names))
            together.append(part.select((*base, *chain.from_iterable(payloads))))
            problems.append(problem)
        return tuple(problems), together

    usual = np.full(robot.n, _USUAL)
    equations = _times(merged(posed(usual, robust=False)[1]), 1.0 / usual)
    # How long residuals remember shows only once the joints' torques are to scale, but for one factor of all.
    try:
        K = 1.0 / free_gains(equations, loads).k
        K *= _USUAL / K.mean()
    except InputError:  # raised again when the gains are asked for
        K = usual
    (problems, together), deletions, reason = posed(K, robust=True), list[tuple[Equations, ...]](), ""
    if robot.drives.loaded:  # the load that friction grows with shows in torques to scale
        equations = _times(merged(part.whole for part in together), 1.0 / K)
    try:
        for k, (problem, own) in enumerate(zip(problems, together, strict=True)):
            others = [part.whole for part in (*together[:k], *together[k + 1 :])]
            left = tuple(_times(merged([*others, part]), 1.0 / K) for part in own.without_each())
            # Blocks that share no motion are left out one recording at a time, those without payload first.
            count = len(problem.loaded.blocks)
            parts = [part for part in (left[:-count], left[-count:]) if part]
            check_blocks(*map(len, parts))
            deletions += parts
    except InputError as error:
        deletions, reason = [], str(error)
    source, by = Source(tuple(loaded), tuple(unloaded), settings.processing_of(robot)), tuple(K.tolist())
    return GainProblem(description, equations, tuple(groups), loads, source, problems, by, tuple(deletions), reason)


def _with_gains(robot: Robot, recording: Recording, K: Array, currents: bool = True) -> Recording:
    """Give a recording the joint torques of its motor currents, or of its joint torques, times K."""
    coupling, torque = robot.coupling, recording.torque
    if coupling is not None and not currents:
        torque = coupling.motor_torques(torque)
    return replace(recording, torque=coupling.joint_torques(torque * K) if coupling else torque * K)


def _times(equations: Equations, ratio: Array) -> Equations:
    """Multiply right-hand sides of joint j by ``ratio[j]``."""
    every = zip(equations.factors, ratio, strict=True)
    factors = tuple(np.column_stack([own[:, :-1], joint_ratio * own[:, -1]]) for own, joint_ratio in every)
    return replace(equations, factors=factors, blocks=tuple(_times(block, ratio) for block in equations.blocks))


def free_gains(equations: Equations, loads: Sequence[KnownLoad]) -> CurrentFit:
    """Solve for gains, base parameters and what is unknown of the payload, without constraints.

    Each joint weighs by its current's error in its own equations alone, so that neither gains nor others matter.
    """
    names, values = equations.columns, known_values(loads, equations.columns)
    free = [k for k, name in enumerate(names) if name not in values]
    base = [k for k, name in enumerate(names) if "_L" not in name]
    shown, sigma, norms = False, [], np.linalg.norm(np.vstack(equations.factors)[:, :-1], axis=0)
    for factor, rows in zip(equations.factors, equations.effective_rows, strict=True):
        W, current = factor[:, :-1], factor[:, -1]
        # What this joint's equations do not hold is not quite zero in them, and would cost degrees of freedom.
        bare, parts = decomposed(W[:, base], norms[base]), decomposed(W, norms)
        less, more = (
            np.linalg.norm(current - A @ x.solution(current)) for A, x in ((W[:, base], bare), (W, parts))
        )
        # A payload that is there explains the current of some joint by itself better.
        shown |= bool(less**2 - more**2 > _SHOWN * less**2)
        error = more / np.sqrt(max(rows - len(parts.singular), 1.0))
        sigma.append(max(error, _FLOOR * np.linalg.norm(current) / np.sqrt(max(rows, 1.0)), 1e-300))
    if not shown:
        raise InputError("the payload does not show in the currents: is it in the loaded recording?")
    known = np.array([values.get(name, 0.0) for name in names])
    fitted = gauss_newton(equations, 1.0 / np.array(sigma), free, known)
    negative = [str(j) for j, k in enumerate(fitted.k, 1) if k <= 0.0]
    if not negative:
        return fitted
    brakes = sum(np.sign(x) for name, x in zip(names, fitted.x, strict=True) if parameter_kind(name) == "FS")
    if len(negative) == len(fitted.k) and brakes < 0:  # Coulomb friction that drives more joints than it brakes
        advice = "the known weight comes out negative; exchange --loaded and --unloaded"
        raise InputError(f"the recordings with and without the payload look exchanged: {advice}")
    advice = "turn its sign (sign in a log map), or check the order of joints"
    raise InputError(f"the current of motor {', '.join(negative)} pushes against its motion: {advice}")


def rests_on(robot: Robot) -> tuple[str, ...]:
    """Name the torques that each motor's gain rests on."""
    # Gravity acts on a motor if some mass of robot or payload weighs on it in some pose.
    q, _, _ = random_states(robot, 20, seed=0)
    heavy = [name for name in standard_columns(robot) if parameter_kind(name) in ("MX", "MY", "MZ", "M")]
    weights = regressor_at(robot, heavy, q, 0.0 * q, 0.0 * q).transpose(1, 2, 0).reshape(-1, robot.n)
    motors = robot.coupling.motor_torques(weights) if robot.coupling else weights
    acts = np.abs(motors).max(axis=0) > 1e-9
    texts = ["gravity and inertia" if a else "inertia only: no gravity acts on this joint" for a in acts]
    if robot.spring is not None:
        texts[robot.spring.joint - 1] += ", and the known spring"
    if robot.coupling is not None:
        j, k = robot.coupling.joints
        texts[j - 1] += f" (the torque of joint {j} less that of joint {k})"
        texts[k - 1] += f" (motor {k} turns with joints {j} and {k})"
    return tuple(texts)


def possible_gains(problem: GainProblem, equations: Equations, start: CurrentFit) -> CurrentFit:
    """Find gains, base parameters and payload of bodies that can exist, drives that do not push.

    ``equations``: all of the problem's or those without a block; ``start``: gains to begin with, whose covariance
    is kept: the gain that it knows best stays while solving.
    """
    robot, base, loads, length = problem.robot, problem.posed[0].base, problem.loads, typical_length(problem.robot)
    k, x, others, c, standard = start.k, start.x, len(start.k) - 1, len(start.x), len(base.standard)
    anchor = int(np.argmin(np.diag(start.covariance)))
    # One mass and one length for all links, one size for friction.
    own = [(parameter_kind(name), abs(value)) for name, value in zip(base.columns, x, strict=False)]
    masses = [value / length ** POWERS[kind] for kind, value in own if kind in INERTIAL]
    frictions = [value for kind, value in own if kind not in POWERS and kind != SPRING]
    mass, friction = float(np.median(masses)) or 1.0, max(float(np.median(frictions or [1.0])), 1e-6)
    inertial = {kind: mass * length**power for kind, power in POWERS.items()}
    sizes = {name: inertial.get(parameter_kind(name), friction) for name in base.standard}
    for columns, load in zip(payload_columns(len(loads)), loads, strict=True):
        sizes |= {name: load.mass * _LENGTH ** POWERS[kind] for name, kind in zip(columns, INERTIAL, strict=True)}
    # The z are, scaled, what is unknown of the robot and the payload, and the factor of all that is known, springs
    # among it; then come the other gains over their present values.
    known, scale = known_values(loads, base.standard), np.array([*sizes.values()])
    free = np.array([name not in known for name in sizes])
    parameters = np.column_stack([np.diag(scale)[:, free], [known.get(name, 0.0) for name in sizes]])
    to_x, m = np.vstack([base.grouping @ parameters[:standard], parameters[standard:]]), parameters.shape[1]
    rules = drive_rules(robot, base.standard, scale[:standard])[0]
    rules = np.pad(rules, ((0, 0), (0, len(scale) - standard)))[:, free]
    A = block_diag(rules, np.eye(1 + others))
    # A body whose ten are all known needs no cone: it was checked when it was read.
    tens = np.arange(standard, len(scale)).reshape(-1, len(PAYLOAD))[[load.known != PAYLOAD for load in loads]]
    to_bodies = parameters[np.vstack([link_indices(robot, base.standard), tens])]
    bodies = np.pad(to_bodies, ((0, 0), (0, 0), (0, others)))
    for _ in range(_LINEARISED):
        J, errors = linearised(equations.factors, start.weights, k, x, range(c))
        by_ratio = np.delete(J[:, c:] * k, anchor, axis=1)
        right = errors + J[:, :c] @ x + by_ratio.sum(axis=1)
        # Below the triangle of the unknowns stands what none of them explains.
        R = triangular(np.column_stack([J[:, :c] @ to_x, by_ratio, right]))[: m + others]
        try:
            z, _ = solve_cone(ConeProgram(R[:, :-1], R[:, -1], A, np.zeros(len(A)), bodies), _WAYS)
        except SolverError as error:
            raise InputError(f"gains of bodies that can exist were not found ({error.explanation})") from None
        ratio, factor = np.insert(z[m:], anchor, 1.0), float(z[m - 1])
        if factor <= 0.0 or (ratio <= 0.0).any():
            raise InputError("no gain explains the currents: check units, signs, order of joints and the payload")
        x, ratio = to_x @ z[:m] / factor, ratio * factor
        k = k * ratio
        if np.abs(ratio - 1.0).max() < _CLOSE:
            return start._replace(k=k, x=x)
    advice = "check units, signs and order of the currents"
    raise InputError(f"the gains of bodies that can exist do not settle: {advice}")


@dataclass(frozen=True, repr=False)
class GainsWorking(Brief):
    """Weighings by the torques that drive gains give, one for each mounting of the known weight."""

    source: Source  # the recordings of currents
    mountings: tuple[int, ...]  # their numbers
    loads: tuple[KnownLoad, ...]
    payloads: tuple[InertialParameters, ...]  # as identified in each mounting, what is known as given
    posed: tuple[LongMotion, ...]
    by_joints: tuple[ByJoints, ...]

    @cached_property
    def predictions(self) -> tuple[TorquePrediction, ...]:
        """Torques of a few recordings, current times gain, and those of robot and weight: all were used."""
        return tuple(chain.from_iterable(map(payload_predictions, self.posed, self.payloads)))[:DRAWN]


@one_thread()
def identify_gains(
    robot: Robot,
    loaded: Sequence[Recording],
    unloaded: Sequence[Recording],
    load: KnownLoad | Sequence[KnownLoad],
    mounting: Sequence[int] = (),
    settings: Settings = DEFAULTS,
) -> GainsResult:
    """Identify drive gains from motor currents without and with a weight that is known, and judge them.

    Args:
        loaded: recordings with the weight, whose ``torque`` holds motor currents [A].
        unloaded: the same without it.
        load: the weight, or that of each mounting.
        mounting: one number for each of ``loaded``; recordings with equal numbers share a centre of mass. All one
            by default.

    Raises:
        InputError: if the recordings do not determine the gains.

    >>> result = identify_gains(robot, currents_loaded, currents, known_mass(7.0))
    >>> result.drive_gains.values[:4].round()
    array([10., 10., 10., 10.])
    """
    check_given(robot, loaded, unloaded)
    return answer_gains(gain_problem(robot, unloaded, loaded, load, mounting, settings))


def answer_gains(problem: GainProblem) -> GainsResult:
    """Identify the drive gains on the current side, with bodies that can exist, and judge them."""
    loads, names = problem.loads, problem.mountings
    try:
        free = free_gains(problem.equations, loads)
        best = possible_gains(problem, problem.equations, free)
    except InputError as error:  # what the recordings look like is told with it
        likely = likely_causes(problem.description, states_of(problem.source), free_gains=True)
        raise InputError("; ".join([str(error), *(finding.text for finding in likely)])) from None
    robust, reason = None, problem.without_blocks
    if problem.deletions:
        try:
            every = problem.deletions
            groups = [[-np.log(possible_gains(problem, part, best).k) for part in group] for group in every]
            robust = jackknife(groups, -np.log(best.k), max(each.loaded.block_length for each in problem.posed))
        except InputError as error:
            reason = str(error)
    # The weight as the torques show it that the gains give; the gains' own errors are those of these recordings.
    posed = problem.posed_by(1.0 / best.k)
    identified = [payload_estimate(each, 4) for each in posed]
    diagnoses = [diagnose(*each, None, problem.description) for each in zip(posed, identified, strict=True)]
    # An error of the weighed mass scales all gains alike, and so may a burst of other torques.
    bursts = zip(identified, (found.effects.get("bursts") for found in diagnoses), strict=True)
    reach = max((abs(float(found.change[9]) / own.mass) / NORMAL95 for own, found in bursts if found), default=0.0)
    shared = max(load.mass_sigma / load.mass for load in loads) ** 2 + reach**2
    factors = zip(problem.equations.factors, best.k, strict=True)
    errors = np.array([np.linalg.norm(R[:, -1] - k * R[:, :-1] @ best.x) for R, k in factors])
    fit = Fit(errors, problem.equations.torque_norms, problem.equations.rows)  # of the currents [A]
    # The covariance of ln K has the larger standard deviations, and the robust correlations where there are some;
    # all times the disagreement of the joints' payload ratios.
    disagreement = max(found.disagreement for found in diagnoses)
    formula = np.sqrt(np.diag(free.covariance) + shared)
    sigma, covariance = disagreement * formula, disagreement**2 * (free.covariance + shared)
    if robust is not None:
        robust = replace(robust, covariance=robust.covariance + shared)
        sigma = disagreement * np.maximum(formula, robust.sigma)
        covariance = robust.covariance * np.outer(sigma / robust.sigma, sigma / robust.sigma)
    gains, well = 1.0 / best.k, (sigma <= KNOWN_WELL).tolist()
    vague = "; too little, known to {:.0f} % only: keep the maker's gain"
    based = zip(rests_on(problem.robot), well, sigma, strict=True)
    table = GainsTable(
        gains,
        covariance,
        sigma=gains * sigma,
        relative_sigma=sigma,
        relative_sigma_formula=formula,
        relative_sigma_robust=robust.sigma if robust else None,
        without_constraints=1.0 / free.k,
        identified=tuple(well),
        rests_on=tuple(text if good else text + vague.format(100 * one) for text, good, one in based),
    )
    each = zip(names, loads, identified, strict=True)
    weights = tuple((name, load.mass, own.mass, float(own.estimate.larger_sigma[9])) for name, load, own in each)
    # What the mountings have in common stands in the evidence of the first.
    evidence = [
        replace(
            found,
            condition=motion.unloaded.condition_numbers()[1] if motion.unloaded else None,
            parameters=motion.robot_estimate,
            estimates=(own,),
            gained=None if k else sigma,
            weights=() if k else weights,
            alternatives=() if k else found.alternatives,
        )
        for k, (motion, own, found) in enumerate(zip(posed, identified, diagnoses, strict=True))
    ]
    robot, source, columns = problem.description, problem.source, len(problem.posed[0].base.columns)
    payloads = tuple(map(InertialParameters, best.x[columns:].reshape(-1, len(PAYLOAD))))
    tens = [named(body.vector) for body in payloads]
    by_joints = tuple(found.by_joints for found in diagnoses)
    return GainsResult(
        robot=robot.name,
        robot_title=robot.title or UNSET,
        processing=ProcessingDocument.made(robot, source.processing, ()),
        load=LoadDocument(
            known=known_values(loads),
            mass_sigma=max(load.mass_sigma for load in loads),
            identified=tens[0],
            mountings=tuple(map(MountingDocument, names, tens)) if len(names) > 1 else UNSET,
        ),
        drive_gains=table,
        fingerprints=fingerprints(source.unloaded, source.loaded),
        robust=RobustDocument.made(robust, reason),
        relative_residual=ResidualDocument.of(fit),
        disagreement=disagreement,
        verdict=judge(*evidence),
    ).made_by(GainsWorking(source, names, loads, payloads, posed, by_joints))
