"""Table of hypotheses that add columns: what other than robot and payload may be in the torques.

A row holds everything about one fault: its columns, from where on it stands out, what it spoils, its text and what
to do. To look for another fault, add a row.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...common import Array
from ...model import Robot
from ...model.frames import point_at
from ...model.friction import is_friction
from ...model.regressors import regressor_at
from ..equations.equations import PAYLOAD
from .engine import BLOCKS, Effect, System, solved
from .evidence import Evidence, Finding, error, note, warning

WITH_PAYLOAD = " with payload"
WHERE = ("", " without payload", WITH_PAYLOAD)  # recordings in which a fault may be: all, or some
MOVED = 0.025  # relative change of the mass above which a fault spoils every number
SLIP, SLIP_Z, SURE = 0.01, 5.0, 3.0
"""Distance [m] by which the centre of mass differs in the second half of the loaded recordings, its standard
deviations, and those of the step's length."""
CHANGE, CHANGE_Z = 0.1, 6.0
"""Fraction of the payload that comes or goes during the loaded recordings, and its standard deviations."""
LATE, LATE_Z = 0.008, 5.0  # delay between torque and position [s], and its standard deviations
LEVEL = np.radians(1.0)
"""Standard deviation [rad] of a base's tilt about either horizontal axis, as mounted arms have it."""
TILT_DEGREES, STEEP_DEGREES, TILT_Z = 0.5, 5.0, 5.0
TILT, STEEP = np.radians(TILT_DEGREES), np.radians(STEEP_DEGREES)
"""Tilt [rad] that is taken out of the payload and reported; smaller ones widen the intervals only. Beyond
``STEEP`` no mounting leans by mistake: nothing should be used."""
WEIGHT, WEIGHT_Z = 0.03, 5.0
"""Relative difference of gravity's size, and its standard deviations: good ones, real ones too, show up to 1.3."""
EARTH = 9.81  # gravity that is likelier than another one, where the torques hardly show which it is [m/s^2]
ZERO_DEGREES, ZERO_Z = 3.0, 5.0
ZERO = np.radians(ZERO_DEGREES)
"""Position [rad] by which a joint's zero may be off, and its standard deviations: good ones show up to 2.5."""
GAIN, GAIN_Z = 0.2, 5.0
"""Relative difference of a joint's torque from what the links that it shares with others need, and its standard
deviations: joint 1 of a real UR10e, which no gravity loads, is .12 to .21 (3 to 6 sigma) off; others up to 3.1."""
PULL, PULL_Z, ALONG_Z = 0.025, 7.0, 4.5
"""Force over the payload's weight, and standard deviations of it, above which something pulls at the flange.

The last: of stiffness and upward force with payload alone, if the stiffness pulls. What a model leaves of a real
arm shows least there, up to 2.8; a force to the side with payload up to 4.8, stiffness in all recordings up to 5.7.
"""
PUSHES = 2.0  # standard deviations of a stiffness below zero beyond which it is none of a hose
LIGHT, LIGHT_Z = 0.05, 5.0
"""Fraction of the payload's weight that the torques do not hold, and its standard deviations."""
DRIFT, DRIFT_Z = 0.1, 5.0
"""Drift of a joint's torque over the payload's there, and its standard deviations: real ones show up to 3.5."""
ALONE = ("compensated", "weight", "zero", "gain", "drift")  # count where no other takes off more
HELPFUL = 0.1
"""Fraction of the squared residual that a fault must take off before other findings may be its doing. A pull always
may: it leaves little residual and moves the mass far."""
BURST, FEWEST, STRETCH = 3.0, 12, 3.0
"""Mean squared residual of a stretch over their median, above which the stretch is left out; stretches of which a
median says something; shortest stretch that is judged [s]: shorter ones of good recordings stand out by chance."""
CLEARER = 1.2
"""Ratio of what a pull takes off to what a tilt, a delay or a slip does, above which it is reported.

A tilted base looks like a force to the side, which takes off as much at most (1.01); a spring that pulls to the
side takes off 1.4 times as much as a tilt, and more.
"""
_TURN, _STEP = 1e-5, 0.01  # rad and s, to either side: over which a torque's change by position, and time, is taken
_UPRIGHT = 1e-9  # sine of the angle between the first axis and gravity
_ALONG, _ACROSS = (0, 3), (1, 2)  # stiffness and upward force; the horizontal force


class Sought(NamedTuple):
    """Columns of torques that a fault adds."""

    columns: Mapping[str, Array]  # n x k x N each, by where the fault may be
    metric: Mapping[str, Array] = {}  # of the size of values, k x k, if it is not their length
    free: Sequence[Array] = ()  # columns that are free beside them, n x k x N each
    by_difference: Array | None = None  # their effect on method 3, if that is another one
    groups: Sequence[Sequence[int]] = ()  # values that are judged together, where not all of them are


class Hypothesis(NamedTuple):
    """A fault that adds columns to the equations."""

    name: str
    sought: Callable[[System], Sought | Effect | None]  # its columns, or its effect; None where nothing can show it
    stands_out: Callable[[Effect], bool]  # more than chance, a model's own errors and its own standard deviation
    finding: Callable[[Effect, Evidence], Finding]
    """What it spoils, the text and what to do; its docstring says from where on."""


def parts(loaded: Array) -> dict[str, Array]:
    """Parts of the states: all, those without and those with payload, as 1 or 0; where all are alike, these."""
    if loaded.all():
        return {WITH_PAYLOAD: loaded}
    masks = np.ones(len(loaded)), 1.0 - loaded, loaded
    return dict(zip(WHERE, masks if loaded.any() else masks[:1], strict=False))


def spoils(evidence: Evidence, change: Array, more: float = 0.0) -> bool:
    """True if a change of the ten moves the mass, by up to ``more`` [kg] more, or the centre of mass."""
    mass = abs(evidence.mass)
    return float(np.linalg.norm(change[6:9])) > SLIP * mass or not abs(change[9]) + more <= MOVED * mass


def torque_delay(system: System) -> Sought:
    """Columns of a delay: the slope of the torques."""
    before, after = (system.states.later(step).torque.T[:, None] for step in (-_STEP, _STEP))
    slope = (after - before) / (2.0 * _STEP)
    return Sought({where: -slope * mask for where, mask in parts(system.states.loaded).items()})


def _delayed(effect: Effect, evidence: Evidence) -> Finding:
    """Torques that are late or early.

    By over {LATE:g} s and {LATE_Z:g} sigma: do not use where the mass is {MOVED:.1%}, or the centre of mass
    {SLIP:g} m off without it, else not the inertia; without payload where it takes {HELPFUL:.0%} off the squared
    residual. Delays come out a third too small; all joints are assumed to have the same one.
    """
    text = (
        f"the torques{effect.where} {'lag' if effect.size > 0.0 else 'lead'} the positions by "
        f"{1e3 * abs(effect.size):.0f} ± {1e3 * effect.sigma:.1g} ms or more: check the log's time stamps"
    )
    if evidence.of_robot:
        return (error if effect.fall > HELPFUL else note)(text)
    if not spoils(evidence, effect.change):
        return warning(text)
    mass = evidence.mass + effect.change[9]
    return error(f"{text}; corrected for it, the mass is {mass:.3g} kg" if np.isfinite(mass) else text)


def after_fraction(system: System, fraction: float) -> Array:
    """Mark the loaded states after a fraction of their time, shape (N,); none where no payload is seen."""
    loaded = system.states.loaded
    seen = bool(loaded.any()) and system.values[system.payload][9] > 0.0
    return np.asarray((np.cumsum(loaded) > fraction * loaded.sum()) * loaded * seen)


def slip(system: System) -> Sought | None:
    """Columns of a step of the centre of mass half way through the loaded recordings."""
    if not system.states.loaded.any():
        return None
    first_moments = system.columns[:, system.payload][:, 6:9] * after_fraction(system, 0.5)
    return Sought({WITH_PAYLOAD: system.values[system.payload][9] * first_moments})


def _slip(effect: Effect, _: Evidence) -> Finding:
    """A payload that slips.

    The centre of mass in the second half of the loaded recordings {SLIP:g} m and {SLIP_Z:g} sigma off: do not use.
    """
    return error(
        f"the centre of mass moves by {1e3 * effect.size:.0f} ± {1e3 * effect.sigma:.1g} mm halfway through the "
        "recordings with payload: did the payload slip?",
        "centre of mass",
    )


def change(system: System) -> Sought:
    """Columns of the fraction of the payload that comes or goes during the loaded recordings."""
    moments, own = np.arange(1, BLOCKS) / BLOCKS, system.carried[:, None]
    return Sought({f"{100 * moment:.0f} %": own * after_fraction(system, moment) for moment in moments})


def _change(effect: Effect, _: Evidence) -> Finding:
    """A payload that is picked up or put down, or torques that drift.

    From some moment on the payload is {CHANGE:.0%} and {CHANGE_Z:g} sigma larger or smaller: do not use.
    """
    return error(
        f"the mass {'grows' if effect.size > 0.0 else 'shrinks'} after {effect.where} of the recordings with "
        "payload: was the payload picked up or put down, or does a torque drift?",
        "mass",
    )


def drift(system: System) -> Sought:
    """Columns of each joint's torque that grows evenly over the recordings without payload, or with it."""
    masks, ones = list(parts(system.states.loaded).items())[-2:], np.eye(system.robot.n)[:, :, None, None]
    constants = {f"{j}{where}": one * mask for j, one in enumerate(ones, 1) for where, mask in masks}
    ramps = {where: column * system.states.passed for where, column in constants.items()}
    usual = np.mean((system.carried if system.carried.any() else system.torque) ** 2, axis=1)
    metric = np.repeat(1.0 / np.maximum(usual, 1e-200), len(masks))[:, None, None]
    return Sought(ramps, dict(zip(ramps, metric, strict=True)), list(constants.values()))


def _drift(effect: Effect, evidence: Evidence) -> Finding:
    """A joint's torque that drifts.

    By over {DRIFT:.0%} of the payload's torque at the joint and {DRIFT_Z:g} sigma, if nothing else explains more:
    do not use; without payload, by that fraction of the joint's torque, if it takes {HELPFUL:.0%} off the squared
    residual.
    """
    joint, *where = effect.where.split(" ", 1)
    return (note if evidence.of_robot and effect.fall <= HELPFUL else error)(
        f"the torque of joint {joint} drifts by {effect.values[0]:.3g} ± {effect.sigma:.1g} (N·m or N) over a "
        f"recording{''.join(f' {part}' for part in where)}: let the arm run warm, and record again"
    )


def tilt(system: System) -> Sought:
    """Columns of angles by which gravity leans about two horizontal axes.

    First moments about a first axis along gravity show in a tilt alone: they are free.
    """
    robot, g, first = system.robot, np.array(system.robot.gravity), system.robot.joints[0]
    across = (np.linalg.norm(g) * upright(robot)[:2]).tolist()
    leaning = [replace(robot, gravity=tuple(gravity)) for gravity in across]
    both, alone = (
        np.concatenate([system.bodies(other, payload_alone=alone) for other in leaning], axis=1)
        for alone in (False, True)
    )
    axis, free, q = np.array([0.0, -np.sin(first.alpha), np.cos(first.alpha)]), list[Array](), system.states.q
    if first.revolute and np.linalg.norm(np.cross(axis, g)) < _UPRIGHT * np.linalg.norm(g):
        free.append(regressor_at(leaning[0], ("MX1", "MY1"), q, 0.0 * q, 0.0 * q))
    if not system.states.loaded.any():
        return Sought({"": both}, free=free)
    # By method 3 the robot is left out: what the columns are to the payload alone.
    part = slice(system.payload.start, None)
    rows = (
        np.concatenate([system.columns[:, part], alone], axis=1) * (system.weights[:, None] * system.keep)[:, None]
    )
    gram = np.einsum("jan,jbn->ab", rows, rows, optimize=True)
    ten = solved(gram, system.prior[part, part])[: len(PAYLOAD)]
    return Sought({"": both}, free=free, by_difference=-ten)


def weight(system: System) -> Sought:
    """Column of gravity's size: the torque of all weights."""
    return Sought({"": system.bodies(system.robot)})


def _weight(effect: Effect, evidence: Evidence) -> Finding:
    """Gravity of a magnitude that differs from the described one.

    By over {WEIGHT:.0%} and {WEIGHT_Z:g} sigma: do not use.
    """
    usual = float(np.linalg.norm(evidence.robot.gravity))
    return error(
        f"the torques show a gravity of {usual * (1.0 + effect.size):.3g} ± {usual * effect.sigma:.1g} m/s², but "
        f"the robot's description says {usual:.4g}: correct it there"
    )


def compensated(system: System) -> Sought:
    """Column of the payload's weight alone, its inertia left."""
    return Sought({WITH_PAYLOAD: -system.bodies(system.robot, payload_alone=True) * after_fraction(system, 0.0)})


def _compensated(effect: Effect, evidence: Evidence) -> Finding:
    """A part of the payload's weight that is missing from the torques, compared with its inertia.

    Over {LIGHT:.0%} of it and {LIGHT_Z:g} sigma, if nothing else explains more: do not use.
    """
    mass = evidence.mass + effect.change[9]
    part = f"{100 * effect.size * evidence.mass / mass:.0f} %" if mass > evidence.mass else "a part"
    return error(
        f"the torques show the payload's inertia but lack {part} of its weight: if a payload is set in the "
        "controller, which compensates for it, remove it and record again"
    )


def zero(system: System) -> Sought:
    """Column of each turning joint's zero: how the torque of links and payload changes with its position."""
    turning = [j for j, joint in enumerate(system.robot.joints) if joint.revolute]
    turns = np.vstack([np.zeros(system.robot.n), np.eye(system.robot.n)[turning]])
    torque = system.bodies(turns=_TURN * turns)
    change = (torque[:, 1:] - torque[:, :1]) / _TURN
    return Sought({str(j + 1): change[:, k : k + 1] for k, j in enumerate(turning)})


def _zero(effect: Effect, _: Evidence) -> Finding:
    """A joint with a wrong zero.

    By over {ZERO_DEGREES:g} degrees and {ZERO_Z:g} sigma, if nothing else explains more: do not use.
    """
    return error(
        f"the zero of q{effect.where} is off: by the torques it reads {np.degrees(abs(effect.size)):.0f} ± "
        f"{np.degrees(effect.sigma):.1g} degrees too {'small' if effect.size > 0.0 else 'large'}. Correct the "
        "zero in a log map, or the robot's description"
    )


def gain(system: System) -> Sought | None:
    """Column of each joint's torque, without friction; None where a spring gives a part of one."""
    if system.robot.spring is not None:
        return None
    rigid = [k for k, name in enumerate(system.names) if not is_friction(name)]
    rigid += range(system.payload.start, system.payload.stop)
    torque = system.values[rigid] @ system.columns[:, rigid]
    return Sought({str(j + 1): np.diag(one)[:, None] @ torque[None] for j, one in enumerate(np.eye(len(torque)))})


def _gain(effect: Effect, _: Evidence) -> Finding:
    """A joint's torque on a different scale from those of its neighbours, which carry the same links.

    By over {GAIN:.0%} and {GAIN_Z:g} sigma, if nothing else explains more: do not use.
    """
    return error(
        f"the torques do not share one scale: joint {effect.where}'s is {1.0 + effect.size:.2f} ± "
        f"{effect.sigma:.1g} times what the neighbouring joints imply: check the drive gains and units (currents, "
        "motor-side torques or percent given as torque?)"
    )


def tilt_correction(lean: Effect, method: int) -> tuple[Array, Array]:
    """Change of a method's ten by correcting a tilt that stands out, shrunk by the prior LEVEL, and its covariance.

    A tilt that does not stand out is left in the ten: the covariance then holds its mean square.
    """
    effect = lean.by_difference if method == 3 and lean.by_difference is not None else lean.effect
    inverse = np.linalg.inv(lean.covariance)
    variance = np.linalg.inv(inverse + np.eye(2) / LEVEL**2)
    mean = variance @ inverse @ lean.values
    if not BY_NAME["tilt"].stands_out(lean):
        return np.zeros(len(effect)), effect @ (variance + np.outer(mean, mean)) @ effect.T
    return effect @ mean, effect @ variance @ effect.T


def _tilt(effect: Effect, evidence: Evidence) -> Finding:
    """A base that is not as described.

    Gravity tilted by over {STEEP_DEGREES:g} degrees and {TILT_Z:g} sigma: do not use. From {TILT_DEGREES:g}
    degrees: a note.
    """
    text = (
        f"gravity is tilted by {np.degrees(effect.size):.1f} ± {np.degrees(effect.sigma):.1g} degrees from the "
        "robot's description (is the base level?)"
    )
    if effect.size > STEEP:
        return error(f"{text}: correct gravity in the robot's file, or --mount")
    left = "the robot's parameters absorb it" if evidence.of_robot else "the payload is corrected for it"
    return note(f"{text}: {left}")


def pull(system: System) -> Sought:
    """Columns of the force of a hose or cable at the flange, which changes with its position.

    Towards a fixed anchor it is F = c - k p, p the flange's position. Four columns: J'p, that of the stiffness k,
    and J'e along two horizontal axes and upwards for the constant c. A constant pull upwards differs from a lighter
    payload by the payload's inertia alone: a slow motion leaves it open, and the mass with it.
    """
    robot, masks = system.robot, parts(system.states.loaded)
    # Of the payload's frame where the flange is not known.
    flange = robot.flange if robot.flange_pose is None else robot.flange @ robot.flange_pose
    position, moved = point_at(robot, np.asarray(flange.p), system.states.q)
    # Forces of a unit of each, and the torques of what the motors need not do.
    constant = np.repeat(upright(robot).T[:, :, None], position.shape[1], axis=2)
    forces = np.concatenate([-position[:, None], constant], axis=1)
    columns = -np.einsum("ajn,akn->jkn", moved, forces)
    weight = float(np.abs(system.values[system.payload][9:]).sum()) * float(np.linalg.norm(robot.gravity))
    squares = {
        where: np.einsum("akn,aln,n->kl", forces, forces, mask) / mask.sum() for where, mask in masks.items()
    }
    metric = {where: square / max(weight, 1e-100) ** 2 for where, square in squares.items()}
    return Sought({where: columns * mask for where, mask in masks.items()}, metric, groups=(_ALONG, _ACROSS))


def _pulls(effect: Effect) -> bool:
    """True if a pull stands out; no hose pushes away from where it ends."""
    along = effect.where == WITH_PAYLOAD and effect.values[0] > 0.0 and effect.z(*_ALONG) > ALONG_Z
    sigma = np.sqrt(np.diag(effect.covariance))
    shown = bool((np.abs(effect.values) > sigma).any()) and effect.values[0] > -PUSHES * sigma[0]
    return effect.size > PULL and shown and (along or effect.z() > PULL_Z)


def pull_of(evidence: Evidence) -> Effect | None:
    """Take the pull, or one of ``ALONE``, that stands out: it may look like a scale or another robot."""
    found = evidence.effects.items()
    return next((one for name, one in found if name in ("pull", *ALONE) and BY_NAME[name].stands_out(one)), None)


def _pull(effect: Effect, evidence: Evidence) -> Finding:
    """A hose or cable that pulls at the flange.

    A force over {PULL:.1%} of the payload's weight and {PULL_Z:g} sigma, or {ALONG_Z:g} sigma of stiffness and
    upward force with payload alone: do not use where the mass may be {MOVED:.1%} (2 sigma), or the centre of mass
    {SLIP:g} m off without it, else not the inertia.
    """
    (stiffness, *_, up), (sigma, *_, up_sigma) = effect.values, np.sqrt(np.diag(effect.covariance))
    sideways = float(np.linalg.norm(effect.values[list(_ACROSS)]))
    force = [f"{stiffness:.3g} ± {sigma:.1g} N/m"] if abs(stiffness) > sigma else []
    force += [f"{sideways:.2g} N to the side"] if effect.z(*_ACROSS) > 1.0 else []
    force += [f"{up:.2g} ± {up_sigma:.1g} N up"] if abs(up) > up_sigma else []
    what = f"{effect.where} something pulls at the flange ({', '.join(force)}), perhaps a hose or cable".strip()
    remedy = "remove it or fasten it along the arm, and record again"
    if evidence.of_robot:
        return note(f"{what}, and the robot's parameters absorb it: {remedy}")
    mass, sigma = evidence.mass + effect.change[9], np.sqrt(effect.effect[9] @ effect.covariance @ effect.effect[9])
    both = np.hypot(sigma, evidence.spread.mass if evidence.spread is not None else 0.0)
    told = f"; without it the mass would be {mass:.3g} ± {both:.1g} kg" if np.isfinite([mass, both]).all() else ""
    against = error if spoils(evidence, effect.change, 2.0 * float(sigma)) else warning
    return against(f"{what}{told}: {remedy}")


def upright(robot: Robot) -> Array:
    """Two horizontal unit vectors and the one upwards; the axes of the base where there is no gravity."""
    g = np.array(robot.gravity)
    if not g.any():
        return np.eye(3)
    up = -g / np.linalg.norm(g)
    across = np.cross(-up, np.eye(3)[int(np.argmin(np.abs(g)))])
    across /= np.linalg.norm(across)
    return np.array([across, np.cross(-up, across), up])


def bursts(system: System) -> Effect | None:
    """Stretches of 3 s whose mean squared residual stands out, and the payload without them.

    None where there are none, or more than half, or few stretches altogether.
    """
    if not system.states.loaded.any():
        return None
    # Stretches begin with each recording.
    states, recording = system.states, system.states.recording
    passed = (states.t - states.t[np.searchsorted(recording, recording)]) / STRETCH
    _, stretch = np.unique(np.stack([recording, passed.astype(int)]), axis=1, return_inverse=True)
    stretch = stretch.ravel()  # one release of numpy keeps the axis
    rows = np.bincount(stretch, system.keep.sum(axis=0))
    grams, rows = system.grams(stretch)[rows > 0], rows[rows > 0]
    values = solved(grams.sum(axis=0), system.prior)[:, 0]
    error = np.append(-values, 1.0)
    means = np.einsum("i,kij,j->k", error, grams, error) / rows
    high = means > BURST * np.median(means)
    if not (0 < 2 * high.sum() <= len(means) and len(means) >= FEWEST):
        return None
    change = (solved(grams[~high].sum(axis=0), system.prior)[:, 0] - values)[system.payload, None]
    return Effect("", np.ones(1), np.zeros((1, 1)), change, size=int(high.sum()), sigma=len(means))


def matter(bursts: Effect, mass: float, sigma: float) -> bool:
    """True if the mass [kg] is another one without bursts; stretches that stand out by chance move it by less."""
    return bool(abs(bursts.change[9]) > max(MOVED * abs(mass), 2.0 * sigma))


def _bursts(effect: Effect, evidence: Evidence) -> Finding:
    """Stretches of time with large residuals.

    Stretches of {STRETCH:g} s whose squared residual is over {BURST:g} times the median: noted where the mass
    without them differs by over {MOVED:.1%} and 2 sigma.
    """
    return note(
        f"{effect.size:.0f} of {effect.sigma:.0f} stretches of {STRETCH:.2g} s have large residuals (contact, a "
        f"hose, a shock?); without them the mass is {evidence.mass + effect.change[9]:.3g} kg, and the intervals "
        "cover both",
        "mass",
    )


HYPOTHESES = (
    Hypothesis("pull", pull, _pulls, _pull),
    # A short motion may show one direction of the step only: its length must be known too.
    Hypothesis("slip", slip, lambda one: one.size > max(SLIP, SURE * one.sigma) and one.z() > SLIP_Z, _slip),
    Hypothesis("change", change, lambda effect: abs(effect.size) > CHANGE and effect.z() > CHANGE_Z, _change),
    Hypothesis("late", torque_delay, lambda effect: abs(effect.size) > LATE and effect.z() > LATE_Z, _delayed),
    Hypothesis("compensated", compensated, lambda one: one.size > LIGHT and one.z() > LIGHT_Z, _compensated),
    Hypothesis("weight", weight, lambda effect: abs(effect.size) > WEIGHT and effect.z() > WEIGHT_Z, _weight),
    Hypothesis("tilt", tilt, lambda effect: effect.size > TILT and effect.z() > TILT_Z, _tilt),
    Hypothesis("bursts", bursts, lambda _: True, _bursts),
    Hypothesis("drift", drift, lambda effect: effect.size > DRIFT and effect.z() > DRIFT_Z, _drift),
    Hypothesis("zero", zero, lambda effect: abs(effect.size) > ZERO and effect.z() > ZERO_Z, _zero),
    Hypothesis("gain", gain, lambda effect: abs(effect.size) > GAIN and effect.z() > GAIN_Z, _gain),
)
BY_NAME = {hypothesis.name: hypothesis for hypothesis in HYPOTHESES}


def seen(system: System) -> dict[str, Effect]:
    """Estimate every hypothesis that the recordings can show, each on its own, all columns in one pass.

    Of the parts of the recordings in which a fault may be, that counts where it stands out and explains most.
    """
    found = [(row, sought) for row in HYPOTHESES if (sought := row.sought(system)) is not None]
    effects = {row.name: sought for row, sought in found if isinstance(sought, Effect)}
    asked = [(row, sought) for row, sought in found if isinstance(sought, Sought)]
    blocks = [[*sought.columns.values(), *sought.free] for _, sought in asked]
    added, end = system.with_columns(*(part for own in blocks for part in own)), 0
    for (row, sought), own in zip(asked, blocks, strict=True):
        edges = end + np.cumsum([0, *(part.shape[1] for part in own)])
        free, end, read = range(edges[len(sought.columns)], edges[-1]), int(edges[-1]), list[Effect]()
        for where, (a, b) in zip(sought.columns, pairwise(edges), strict=False):
            effect = added.effect(range(a, b), free, where)
            effect = effect._replace(by_difference=sought.by_difference, groups=sought.groups)
            if where in sought.metric:
                square = float(effect.values @ sought.metric[where] @ effect.values)
                read.append(effect._replace(size=float(np.sqrt(max(square, 0.0)))))
            elif np.isfinite(effect.sigma):
                read.append(effect)
        if read:
            effects[row.name] = max(read, key=lambda effect: (row.stands_out(effect), effect.fall))
    return effects


def effects_of(system: System, free_gains: bool = False, least: float = 0.0) -> dict[str, Effect]:
    """Estimate every hypothesis; a pull replaces the tilt where it takes off clearly more than all others.

    Those of ``ALONE``, which much looks like a little, are kept if they take off ``least`` and nothing else more;
    none of a gain where gains are what is asked for, ``free_gains``.
    """
    if not system.keep.any():
        return {}
    effects = {name: effect for name, effect in seen(system).items() if name != "gain" or not free_gains}
    pull, falls = effects["pull"], {name: effect.fall for name, effect in effects.items() if name != "pull"}
    off = max(falls.pop(name, 0.0) for name in ("compensated", "zero", "gain", "drift"))
    hung = _pulls(pull) and pull.fall > max(CLEARER * max(falls.values(), default=0.0), off)
    effects.pop("tilt" if hung else "pull", None)
    most = max([least, *(one.fall for name, one in effects.items() if BY_NAME[name].stands_out(one))])
    return {name: effect for name, effect in effects.items() if name not in ALONE or effect.fall >= most}


def hypotheses(evidence: Evidence) -> list[Finding]:
    """Findings of all rows of ``HYPOTHESES`` that stand out."""
    findings = []
    for name, effect in evidence.effects.items():
        if BY_NAME[name].stands_out(effect):
            finding = BY_NAME[name].finding(effect, evidence)
            cause = finding.severity == "error" and (name in ("pull", *ALONE) or effect.fall > HELPFUL)
            findings.append(finding._replace(cause=cause, explains=effect.fall))
    return findings
