"""Scales of torques: of those with payload over those without, and of the joints of one recording.

The first is one more column of method 4 in the loaded rows: the rigid part of what the robot alone needs, friction
and offsets of those rows free. All of it is in the joints' triangular factors, so that no row is read again; beside
a robot that is known, and in a short motion, subsampled states do.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...common import Array
from ...model.friction import is_friction
from ..equations.equations import PAYLOAD
from ..fit.covariance import NORMAL95
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem
from .engine import Added, Effect, System
from .evidence import Evidence
from .finding import Finding, error, note, warning
from .hypotheses import HELPFUL, pull_of
from .joints import TOGETHER

SCALE, SCALE_Z = 0.01, 4.0
"""Difference of the loaded torques' scale from 1, and its standard deviations, above which it is another one."""
JOINT_SCALE, JOINT_SCALE_Z = 0.05, 5.0
"""Limits for one joint's torque: difference of its scale from 1, and its standard deviations."""
OWN_SCALE_Z = 3.3
"""Standard deviations of one motor's scale with payload, where over 5 % off, above which its gain is not kept."""
EITHER = 0.67
"""Fraction of the largest z from which on another scale of all torques, or of one joint's, explains them as
well."""
HIDDEN, SENSITIVE = (0.01, 0.05), 0.03
"""Least and largest error of the loaded torques' scale that recordings are thought to hide, and the relative change
of the mass by what they do hide above which it is reported."""


def scales(problem: PayloadProblem, weights: Array, system: System | None) -> tuple[Effect, ...]:
    """Estimate scales of the loaded torques, of all and of each joint: by full factors, else by subsampled states.

    None where the scale is an unknown of the problem; full factors need recordings without payload.
    """
    n, by_states = problem.robot.n, tuple[Effect, ...]()
    if system is not None:
        rigid = [k for k, name in enumerate(system.names) if not is_friction(name)]
        along = (system.values[rigid] @ system.columns[:, rigid]) * system.states.loaded
        prior = np.array(system.prior)
        prior[system.payload.stop :, system.payload.stop :] = 0.0  # friction under load is free
        free = replace(system, prior=prior)
        by_states = _effects(free.with_columns(along[:, None], np.eye(n)[:, :, None] * along[:, None]), n)
    if not isinstance(problem, LongMotion) or problem.unloaded is None:
        return by_states
    unloaded, loaded = problem.unloaded, problem.loaded
    if problem.settings.scale_sigma > 0.0 or problem.bare is None or not loaded.blocks:
        return ()
    b, robot = len(unloaded.columns), problem.bare.values
    friction = [k for k, name in enumerate(unloaded.columns) if is_friction(name)]
    rigid, c = [k for k in range(b) if k not in friction], b + len(PAYLOAD)
    # Columns: robot, payload, friction under load, scale of all and of each joint; the torque last.
    unknown = c + len(friction)
    column = np.eye(unknown + n + 2)
    own, carried = column[[*range(b), -1]], column[[*range(c), -1]]
    carried[friction] = column[c:unknown]
    carried[rigid, unknown] = robot[rigid]
    of_joints = [np.array(carried) for _ in range(n)]
    for j, change in enumerate(of_joints):
        change[rigid, unknown + 1 + j] = robot[rigid]
    without, with_payload = list[Array](), list[Array]()
    for grams, equations, changes in ((without, unloaded, [own] * n), (with_payload, loaded, of_joints)):
        for block in equations.blocks:
            rows = np.vstack([w * R @ M for w, R, M in zip(weights, block.factors, changes, strict=True)])
            grams.append(rows.T @ rows)
    # Blocks of one motion are left out together.
    together = len(without) == len(with_payload)
    blocks = np.add(without, with_payload) if together else np.array([*without, *with_payload])
    found = _effects(Added.of(blocks, np.zeros((unknown, unknown)), slice(b, c)), n)
    # The limits were measured with these blocks, however few: none of 111 good recordings passes them. What they
    # take off is compared with that of hypotheses, which go by states.
    falls = [one.fall for one in by_states] or [0.0] * len(found)
    return tuple(one._replace(few=1.0, fall=fall) for one, fall in zip(found, falls, strict=True))


def _effects(added: Added, n: int) -> tuple[Effect, ...]:
    wheres = ["", *(f"joint {joint}" for joint in range(1, n + 1))]
    return tuple(added.effect([k], where=where) for k, where in enumerate(wheres))


def scale(evidence: Evidence) -> Iterator[Finding]:
    """Loaded torques on a different scale from the unloaded ones, all or one joint's.

    All by {SCALE:.0%} and {SCALE_Z:g} sigma, or one joint's by {JOINT_SCALE:.0%} and {JOINT_SCALE_Z:g} sigma, and
    more clearly than a pull: do not use. Both are named if the data hardly distinguish them.
    """
    found, pull = sorted(evidence.diagnosis.scales, key=Effect.z, reverse=True), pull_of(evidence)
    off = [scale for scale in found if beyond(scale)]
    if not off or (pull is not None and pull.z() > off[0].z()):
        return
    worst = off[0]
    others = [scale for scale in off if bool(scale.where) != bool(worst.where) and scale.z() > EITHER * worst.z()]
    likely = sorted([worst, *others[:1]], key=lambda scale: scale.where)  # that of all torques first
    whose = f"{worst.where}'s torques" if worst.where else "the torques"
    whose = f"all torques, or only those of {likely[1].where}," if others else whose
    masses = " or ".join(f"{(evidence.mass + scale.change[9]) / (1.0 + scale.size):.3g}" for scale in likely)
    ratios = " or ".join(f"{1.0 + scale.size:.3f} ± {scale.sigma:.2g}" for scale in likely)
    text = (
        f"the scale of {whose} changes by a factor of {ratios} with payload; without this change the mass would be "
        f"{masses} kg: check units and drive gains, and what changed between the recordings"
    )
    yield error(text)._replace(cause=worst.fall > HELPFUL, explains=worst.fall)


def beyond(scale: Effect, joint_z: float = JOINT_SCALE_Z) -> bool:
    """True if a scale is another one."""
    least, z = (JOINT_SCALE, joint_z) if scale.where else (SCALE, SCALE_Z)
    return abs(scale.size) > least and scale.z() > z


def sensitive(evidence: Evidence) -> Iterator[Finding]:
    """Mass that an unnoticed scale error of the loaded torques would move out of its interval.

    An error of 1.96 sigma, {HIDDEN[0]:.0%} to {HIDDEN[1]:.0%}, moves it by over {SENSITIVE:.0%}: do not use if
    intervals grow by over {TOGETHER:g} (Birge), else noted; not if a different scale is seen,
    something pulls at the flange, or the payload was weighed.
    """
    mass, whole = evidence.mass, next((scale for scale in evidence.diagnosis.scales if not scale.where), None)
    weighed = any(payload.result.weighings for payload in evidence.constrained) or pull_of(evidence) is not None
    weighed = weighed or (evidence.weighed is not None and evidence.weighed.from_scale)
    if whole is None or evidence.spread is None or weighed or not mass > 0.0 or beyond(whole):
        return
    hidden = float(np.clip(NORMAL95 * whole.sigma, *HIDDEN))
    change = hidden * abs(mass - float(whole.effect[9, 0]))
    if change > max(SENSITIVE * mass, NORMAL95 * evidence.spread.mass):
        advice = f"; --scale-sigma {100 * hidden:.2g}% allows for it" if evidence.weighed is None else ""
        apart = evidence.diagnosis.disagreement > TOGETHER
        yield (error if apart else note)(
            f"{'the joints disagree about the payload, and ' if apart else ''}a scale error of {100 * hidden:.2g} "
            f"% in the torques with payload would go unnoticed (measured scale {1.0 + whole.size:.3f} ± "
            f"{whole.sigma:.2g}) and shift the mass by {100 * change / mass:.1f} %, out of its interval{advice}",
            "mass",
        )


def motors_apart(evidence: Evidence) -> Iterator[Finding]:
    """Currents of one motor with payload on a different scale from those without (`gains`).

    By over {JOINT_SCALE:.0%} and {OWN_SCALE_Z:g} sigma: not its gain.
    """
    off = [scale for scale in evidence.diagnosis.scales if scale.where and beyond(scale, OWN_SCALE_Z)]
    worst = max((scale for scale in off if scale.z() <= JOINT_SCALE_Z), key=Effect.z, default=None)
    if evidence.gained is not None and worst is not None:
        yield warning(
            f"motor {worst.where.split()[1]}: the scale of its currents with payload is {1.0 + worst.size:.2f} ± "
            f"{worst.sigma:.2g} times that without; keep the maker's gain there",
            "gain",
        )
