"""The problem of drive gains, currents without and with known weights, reduced, and its free solution.

Least squares on the currents, i_j = k_j (W_j x) + rho_j, over k and x, by Gauss-Newton.

The errors are in the currents. Fitting torques, K_j i_j = W_j x, has them in a regressor's place and gives gains
that are too small (on a UR10e by 10 % and more); it serves as the start only (its linear system is that of Gautier
and Briot, Global identification of joint drive gains and dynamic parameters of robots, 2014).

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
from scipy.linalg import block_diag

from ...common import Array, Brief, InputError, decomposed
from ...common.schema import Real, WrongKeyError
from ...model import INERTIAL, Recording, Robot, standard_columns
from ...model.base import random_states
from ...model.drives import SPRING, parameter_kind
from ...model.files.robot_file import BodyTable
from ...model.regressors import regressor_at
from ..equations.equations import PAYLOAD, Equations, check_blocks, merged, triangular
from ..equations.observer import Arrays
from ..fit.settings import DEFAULTS, Candidates, Settings
from ..payload.long_motion import LongMotion, Source, in_payload_frame, payload_problem
from ..possible.constraints import ConeProgram, SolverError, solve_cone
from ..possible.robot import POWERS, drive_rules, link_indices, typical_length
from ..signals.recordings import without_dead

_SHOWN = 0.05  # of a joint's squared residual: what a payload that is there takes off at least
_USUAL = 10.0  # N·m/A: the size of an arm's gains, so that checks of torques see torques; divided out again
_MOST = 200  # iterations
_LONGEST = 0.5  # step of a gain, relative
_ENOUGH = 1e-9  # relative change of a gain
_ROUNDS = 3  # of weights for the start
_SPREAD = 10.0  # of gains about their median, as far as weights go
_FLOOR = 1e-9  # of the current: data without noise still need finite weights


class CurrentFit(NamedTuple):
    """Gains and parameters, free or of bodies that can exist."""

    k: Array  # A/(N·m), shape (n,)
    x: Array  # all parameters, shape (c,)
    covariance: Array  # of ln K by the free fit, n x n, for white noise
    degrees_of_freedom: float


def current_weights(equations: Equations) -> Array:
    """Weights of the joints: one over the standard deviation of the current's error [1/A], shape (n,).

    From the joint's own equations alone, so that neither gains nor other joints matter.
    """
    sigma, whole = [], np.linalg.norm(np.vstack(equations.factors)[:, :-1], axis=0)
    for factor, rows in zip(equations.factors, equations.effective_rows, strict=True):
        W, d = factor[:, :-1], factor[:, -1]
        # What this joint's equations do not hold is not quite zero in them, and would cost degrees of freedom.
        parts = decomposed(W, whole)
        error = np.linalg.norm(d - W @ parts.solution(d)) / np.sqrt(max(rows - parts.rank, 1.0))
        sigma.append(max(error, _FLOOR * np.linalg.norm(d) / np.sqrt(max(rows, 1.0)), 1e-300))
    return 1.0 / np.array(sigma)


def gauss_newton(equations: Equations, weights: Array, free: Sequence[int], known: Array) -> CurrentFit:
    """Minimise sum_j w_j^2 ||i_j - k_j W_j x||^2.

    ``free``: indices of the unknown parameters; ``known``: the others' values, which set the scale, shape (c,).
    """
    c, factors, x, size = len(free), equations.factors, known.copy(), np.ones(len(equations.factors))
    for _ in range(1 + _ROUNDS):  # the torque side, K_j i_j = W_j x, is linear in K and x
        rows = [w * factor for w, factor in zip(size, factors, strict=True)]
        A = np.hstack([np.vstack([R[:, free] for R in rows]), block_diag(*(-R[:, -1:] for R in rows))])
        solution = decomposed(A).solution(-np.concatenate([R[:, :-1] @ known for R in rows]))
        K = solution[c:]
        if not (np.abs(K) > 1e-12 * np.abs(K).max()).all():
            raise InputError("the payload does not show in the currents: is it in the loaded recording?")
        x[free], k = solution[:c], 1.0 / K
        # Each joint weighted by the errors of its torque: a disturbance of the arm's would outweigh the wrist's.
        middle = float(np.median(np.abs(k)))
        size = weights * np.clip(np.abs(k), middle / _SPREAD, middle * _SPREAD)
    step = np.full(c + len(k), np.inf)
    for _ in range(_MOST):
        J, error = linearised(factors, weights, k, x, free)
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
    return CurrentFit(k, x, float(error @ error) / dof * parts.covariance[c:, c:] / np.outer(k, k), dof)


def linearised(factors: Arrays, weights: Array, k: Array, x: Array, free: Sequence[int]) -> tuple[Array, Array]:
    """Jacobian of the predicted currents by the free x and k, and the currents' errors, both weighted."""
    torques = [factor[:, :-1] @ x for factor in factors]
    by_x = [w * own * factor[:, free] for factor, w, own in zip(factors, weights, k, strict=True)]
    by_k = [(w * torque)[:, None] for w, torque in zip(weights, torques, strict=True)]
    J = np.hstack([np.vstack(by_x), block_diag(*by_k)])
    parts = zip(factors, weights, k, torques, strict=True)
    return J, np.concatenate([w * (factor[:, -1] - own * torque) for factor, w, own, torque in parts])


class KnownLoad(BodyTable, frozen=True, kw_only=True, dict=True):
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

    @cached_property
    def ten(self) -> Array:
        """Known ones of the ten at their index, zero for the others, shape (10,)."""
        return np.where([name in self.known for name in PAYLOAD], self.body().vector, 0.0)


def payload_columns(mountings: int) -> tuple[tuple[str, ...], ...]:
    """Names of the payload's ten parameters in each mounting: ``PAYLOAD``, then XX_L2 .. M_L2, and so on."""
    return tuple(tuple(f"{name}{k if k > 1 else ''}" for name in PAYLOAD) for k in range(1, mountings + 1))


def known_values(loads: Sequence[KnownLoad]) -> dict[str, float]:
    """Collect the known parameters of the payload in each mounting, by the names of ``payload_columns``."""
    return {
        column: float(value)
        for columns, load in zip(payload_columns(len(loads)), loads, strict=True)
        for column, name, value in zip(columns, PAYLOAD, load.ten, strict=True)
        if name in load.known
    }


def known_mass(mass: float, sigma: float = 0.0) -> KnownLoad:
    """Make a payload of which only the mass [kg] is known, with its standard deviation [kg]."""
    return KnownLoad(mass=mass, mass_sigma=sigma)


def mountings(
    numbers: Sequence[int], load: KnownLoad | Sequence[KnownLoad], loaded: int
) -> tuple[dict[int, tuple[int, ...]], tuple[KnownLoad, ...]]:
    """Group the loaded recordings, this many, by the number of their mounting: one number, one centre of mass.

    Returns:
        The indices of each number's recordings, in the order in which they come, and the load of each.
    """
    if numbers and len(numbers) != loaded:
        given = f"{len(numbers)} numbers of mountings for {loaded} loaded recording{'s' * (loaded != 1)}"
        raise InputError(f"{given}: give one number for each of them, in their order, such as 1,2,2 (--mounting)")
    numbers = tuple(numbers) or (1,) * loaded
    groups = {name: tuple(k for k, number in enumerate(numbers) if number == name) for name in numbers}
    if not isinstance(load, KnownLoad):
        if len(load) != len(groups):
            raise InputError(f"{len(load)} known payloads for {len(groups)} mountings: give one, or one for each")
        return groups, tuple(load)
    if len(groups) > 1 and load.com is not None:
        advice = "omit com and inertia_com, or give one mounting"
        raise InputError(f"several mountings cannot share one centre of mass: {advice}")
    return groups, (load,) * len(groups)


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

    @cached_property
    def weights(self) -> Array:
        """Weights per joint: one over the standard deviation of its current's error [1/A]."""
        return current_weights(self.equations)

    def posed_by(self, K: Array) -> tuple[LongMotion, ...]:
        """Pose each mounting's payload problem with torques that gains K give."""
        ratio = K / np.array(self.posed_with)

        def scaled(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
            return tuple(_with_gains(self.robot, one, ratio, currents=False) for one in recordings)

        def changed(problem: LongMotion) -> LongMotion:
            source, load = problem.source, _times(problem.loaded, ratio)
            source = source._replace(loaded=scaled(source.loaded), unloaded=scaled(source.unloaded))
            bare, change = (part and _times(part, ratio) for part in (problem.unloaded, problem.difference))
            return replace(problem, loaded=load, unloaded=bare, difference=change, source=source)

        return tuple(map(changed, self.posed))


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
    groups, loads = mountings(mounting, load, len(loaded))
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
            named = part.transformed(np.eye(len(part.columns)), (*base, *names))
            together.append(named.select((*base, *chain.from_iterable(payloads))))
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
    if coupling is None:
        return replace(recording, torque=torque * K)
    motors = torque if currents else coupling.motor_torques(torque)
    return replace(recording, torque=coupling.joint_torques(motors * K))


def _times(equations: Equations, ratio: Array) -> Equations:
    """Multiply right-hand sides of joint j by ``ratio[j]``."""
    every = zip(equations.factors, ratio, strict=True)
    factors = tuple(np.column_stack([own[:, :-1], joint_ratio * own[:, -1]]) for own, joint_ratio in every)
    return replace(equations, factors=factors, blocks=tuple(_times(block, ratio) for block in equations.blocks))


def free_gains(equations: Equations, loads: Sequence[KnownLoad]) -> CurrentFit:
    """Solve for gains, base parameters and what is unknown of the payload, without constraints."""
    names, values = equations.columns, known_values(loads)
    values |= {name: 1.0 for name in names if parameter_kind(name) == SPRING}
    free = [k for k, name in enumerate(names) if name not in values]
    # A payload that is there explains the current of some joint by itself better.
    base = [k for k, name in enumerate(names) if "_L" not in name]
    for factor in equations.factors:
        W, current = factor[:, :-1], factor[:, -1]
        less, more = (float(np.sum((current - A @ decomposed(A).solution(current)) ** 2)) for A in (W[:, base], W))
        if less - more > _SHOWN * less:
            break
    else:
        raise InputError("the payload does not show in the currents: is it in the loaded recording?")
    known = np.array([values.get(name, 0.0) for name in names])
    fitted = gauss_newton(equations, current_weights(equations), free, known)
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


_LINEARISED = 50  # cone programs
_CLOSE = 1e-5  # relative change of a gain
_WAYS = ((1e5, np.inf), (1e5, 1e3), (1e5, 1e2), (1e3, 1e2), (1e2, 1e2), (1e2, 30.0))
"""Bounds on the scaled unknowns, entry and radius: what no current shows has no least value, and may run away."""
_LENGTH = 0.1  # m: size of a payload, for scaling only


def possible_gains(problem: GainProblem, equations: Equations, start: CurrentFit, anchor: int) -> CurrentFit:
    """Find gains, base parameters and payload of bodies that can exist, drives that do not push.

    ``equations``: all of the problem's or those without a block; ``start``: gains to begin with, whose covariance
    is kept; ``anchor``: index of the gain that stays while solving.
    """
    robot, base, loads, length = problem.robot, problem.posed[0].base, problem.loads, typical_length(problem.robot)
    spring = np.array([parameter_kind(name) == SPRING for name in base.standard])
    names = [name for name in base.standard if parameter_kind(name) != SPRING]
    unknown = [(load, name) for load, one in enumerate(loads) for name in PAYLOAD if name not in one.known]
    # The z are, scaled, standard parameters of the robot, unknown ones of the payload and the factor of its known
    # ones; then come the other gains over their present values.
    k, x, others, s, c = start.k, start.x, len(start.k) - 1, len(names), len(start.x)
    m = s + len(unknown) + 1
    # One mass and one length for all links, one size for friction.
    own = [(parameter_kind(name), abs(value)) for name, value in zip(base.columns, x, strict=False)]
    masses = [value / length ** POWERS[kind] for kind, value in own if kind in INERTIAL]
    frictions = [value for kind, value in own if kind not in POWERS and kind != SPRING]
    mass, friction = float(np.median(masses)) or 1.0, max(float(np.median(frictions or [1.0])), 1e-6)
    scale, payloads = np.ones(m), np.zeros((len(loads), len(PAYLOAD), m))
    kinds = map(parameter_kind, names)
    scale[:s] = [mass * length ** POWERS[kind] if kind in POWERS else friction for kind in kinds]
    scale[s:-1] = [loads[load].mass * _LENGTH ** POWERS[name.removesuffix("_L")] for load, name in unknown]
    for column, (load, name) in enumerate(unknown, s):
        payloads[load, PAYLOAD.index(name), column] = 1.0
    payloads[:, :, -1] = [load.ten for load in loads]
    to_base = np.zeros((len(base.columns), m))
    to_base[:, :s] = base.grouping[:, ~spring]
    to_base[:, -1] = base.grouping[:, spring].sum(axis=1)  # a spring's torque: its parameter is 1
    to_x = np.vstack([to_base, *payloads]) * scale
    A = block_diag(drive_rules(robot, names, scale[:s])[0], np.zeros((0, len(unknown))), np.eye(1 + others))
    # A body whose ten are all known needs no cone: it was checked when it was read.
    open_ones = [body for body, load in zip(payloads, loads, strict=True) if load.known != PAYLOAD]
    to_bodies = np.array([*np.eye(s, m)[link_indices(robot, names)], *open_ones]) * scale
    bodies = np.pad(to_bodies, ((0, 0), (0, 0), (0, others)))
    for _ in range(_LINEARISED):
        J, errors = linearised(equations.factors, problem.weights, k, x, range(c))
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
