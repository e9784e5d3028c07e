"""Whether torques are to one scale: those with payload and those without, and those of the joints of one recording.

The first is one more column of method 4 in the loaded rows: the rigid part of what the robot alone needs, friction
and offsets of those rows free. All of it is in the joints' triangular factors, so that no row is read again; beside
a robot that is known, and in a short motion, subsampled states do.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.arrays import Array
from ...common.errors import InputError
from ...model.drives import FRICTION, parameter_kind
from ..equations.equations import PAYLOAD, Equations
from ..equations.leave_one_out import WithoutEach
from ..gains.current_side import RelativeScales, relative_scales
from ..payload.problem import PayloadProblem
from .engine import Added, System
from .evidence import Evidence, Scale
from .finding import Finding, error, note, warning
from .hypotheses import pull_of, pull_z

SCALE, SCALE_Z = 0.01, 4.0
"""Difference of the loaded torques' scale from 1, and its standard deviations, above which it is another one."""
JOINT_SCALE, JOINT_SCALE_Z = 0.05, 5.0
"""The same limits of one joint's torque."""
OWN_SCALE_Z = 3.3
"""Standard deviations of one motor's scale with payload, where over 5 % off, above which its gain is not kept."""
EITHER = 0.67
"""Fraction of the largest z from which on another scale of all torques, or of one joint's, explains them as
well."""
HIDDEN, SENSITIVE = (0.01, 0.05), 0.03
"""Least and largest error of the loaded torques' scale that recordings are thought to hide, and the relative change
of the mass by what they do hide above which it is reported."""
NORMAL95 = 1.96
OFF_SCALE, OFF_SCALE_Z = 0.12, 4.0
"""Relative difference of two joints' scales, and its standard deviations, beyond friction and noise."""
LONG_ENOUGH = 10.0
"""s: errors of the model last about a second, so that shorter recordings do not tell how they scatter."""


def scales(problem: PayloadProblem, weights: Array) -> tuple[Scale, ...]:
    """Scales of the loaded torques by full factors: of all, and of each joint.

    Args:
        problem: with recordings without payload, else nothing is known of a scale, and one that is not free.
        weights: of the joints.
    """
    bare, loaded = problem.unloaded, problem.loaded
    if problem.scale is not None or problem.bare is None or bare is None or not loaded.leave_one_out:
        return ()
    names, robot = bare.columns, problem.bare.values
    b, c, n = len(names), len(names) + len(PAYLOAD), problem.robot.n
    friction = [k for k, name in enumerate(names) if parameter_kind(name) in FRICTION]
    rigid, size = [k for k in range(b) if k not in friction], c + len(friction) + n + 2

    def gram(unloaded: Equations | None, heavy: Equations | None) -> Array:
        """Gram matrix of robot, payload, friction under load, scale of all and of each joint, torque."""
        total = np.zeros((size, size))
        for j, weight in enumerate(weights):
            if unloaded is not None:
                own = weight * unloaded.factors[j]
                total[np.ix_([*range(b), -1], [*range(b), -1])] += own.T @ own
            if heavy is not None:
                factor = weight * heavy.factors[j]
                rows = np.zeros((len(factor), size))
                index = [*rigid, *range(b, c), -1]
                rows[:, index], rows[:, c : c + len(friction)] = factor[:, index], factor[:, friction]
                rows[:, -2 - n] = rows[:, j - 1 - n] = factor[:, rigid] @ robot[rigid]
                total += rows.T @ rows
        return total

    without, with_payload = _blocks(bare), _blocks(loaded)
    if min(len(with_payload), len(without)) < 2:
        return ()
    if problem.paired:
        blocks = [gram(*pair) for pair in zip(without, with_payload, strict=True)]
    else:
        blocks = [gram(part, None) for part in without] + [gram(None, part) for part in with_payload]
    unknown = c + len(friction)
    return _scales(Added.of(np.array(blocks), np.zeros((unknown, unknown)), slice(b, c)), n)


def _blocks(equations: Equations) -> Sequence[Equations]:
    cut = equations.leave_one_out
    return cut.blocks if isinstance(cut, WithoutEach) else ()


def scales_of_states(system: System) -> tuple[Scale, ...]:
    """Scales of the loaded torques by subsampled states: beside a known robot, or in a short motion."""
    rigid = [k for k, name in enumerate(system.names) if parameter_kind(name) not in FRICTION]
    along = np.einsum("jcn,c->jn", system.columns[:, rigid], system.values[rigid]) * system.states.loaded
    each = np.eye(len(along))[:, :, None] * along[:, None]
    prior, free = np.array(system.prior), range(system.payload.stop, len(system.prior))
    prior[free, free] = 0.0
    added = replace(system, prior=prior).with_columns(np.concatenate([along[:, None], each], axis=1))
    return _scales(added, len(along))


def _scales(added: Added, n: int) -> tuple[Scale, ...]:
    plain, scales = float(added.payload[9, -1]), []
    for joint in range(n + 1):
        answer = added.effect(joint)
        value, effect = float(answer.values[0]), float(answer.effect[9, 0])
        sigma, mass = float(np.sqrt(answer.covariance[0, 0])), (plain + effect * value) / (1.0 + value)
        scales.append(Scale(joint, 1.0 + value, sigma if np.isfinite(sigma) else np.inf, mass, plain - effect))
    return tuple(scales)


def signal_scales(equations: Equations) -> RelativeScales | None:
    """Scales of the joints' signals, as links that several joints carry show; None where nothing tells them.

    Errors by blocks of time count besides the formula's: errors of the model last, and look certain to a formula.
    """
    try:
        return relative_scales(equations, _blocks(equations))
    except InputError:
        return None


def off_scale(evidence: Evidence) -> list[Finding]:
    """Scales of the joints of one recording: those of links that several joints carry differ.

    By over {OFF_SCALE:.0%} and {OFF_SCALE_Z:g} sigma: spoils single numbers.
    """
    signals = evidence.diagnosis.signals
    if signals is None:
        return []
    off = np.abs(np.log(signals.ratio))
    off = np.flatnonzero((off > OFF_SCALE) & (off > OFF_SCALE_Z * signals.sigma))
    if not off.size:
        return []
    factors = ", ".join(f"joint {j + 1} {signals.ratio[j]:.3g} (sigma {100 * signals.sigma[j]:.0f} %)" for j in off)
    return [
        warning(
            f"the torques are not to one scale: to agree with joint {signals.held + 1}'s, they would have to be "
            f"multiplied at {factors}. Looks like currents, motor-side torques or percent given as torque: give "
            "--drive-gains, gear ratios or rated values",
            "torques",
        )
    ]


def scale(evidence: Evidence) -> list[Finding]:
    """Loaded torques, all or one joint's, on another scale than the unloaded ones.

    All by {SCALE:.0%} and {SCALE_Z:g} sigma, one joint's by {JOINT_SCALE:.0%} and {JOINT_SCALE_Z:g} sigma, and by
    more sigma than a pull: spoils all. Both are named where the data hardly distinguish them.
    """
    off = sorted(filter(_is_off, evidence.diagnosis.scales), key=lambda found: -abs(found.z))
    pull = pull_of(evidence)
    if not off or (pull is not None and pull_z(pull) > abs(off[0].z)):
        return []
    worst = off[0]
    others = [s for s in off if bool(s.joint) != bool(worst.joint) and abs(s.z) > EITHER * abs(worst.z)]
    likely = sorted([worst, *others[:1]])  # that of all torques, joint 0, first
    whose = f"joint {worst.joint}'s torques" if worst.joint else "the torques"
    if others:
        whose = f"all torques, or joint {likely[1].joint}'s alone,"
    masses = " or ".join(f"{found.mass:.3g}" for found in likely)
    ratios = " or ".join(f"{found.ratio:.3f} ± {found.sigma:.2g}" for found in likely)
    return [
        error(
            f"{whose} with payload are on another scale: {ratios} times those without; on one scale the mass would "
            f"be {masses} kg: check units, drive gains and what changed in between"
        )
    ]


def _is_off(scale: Scale) -> bool:
    size, z = (JOINT_SCALE, JOINT_SCALE_Z) if scale.joint else (SCALE, SCALE_Z)
    return abs(scale.ratio - 1.0) > size and abs(scale.z) > z


def sensitive(evidence: Evidence) -> list[Finding]:
    """Mass that an error of the loaded torques' scale, too small to be seen, takes out of its interval.

    An error of 1.96 sigma, {HIDDEN[0]:.0%} to {HIDDEN[1]:.0%}, moves it by over {SENSITIVE:.0%}: noted, unless
    something pulls at the flange or the payload was weighed.
    """
    whole = next((scale for scale in evidence.diagnosis.scales if scale.joint == 0), None)
    if whole is None or evidence.spread is None or not evidence.mass > 0.0 or pull_of(evidence) is not None:
        return []
    hidden = float(np.clip(NORMAL95 * whole.sigma, *HIDDEN))
    change = hidden * abs(whole.effect)
    weighed = any(payload.weighings for payload in evidence.constrained)
    if weighed or not change > max(SENSITIVE * evidence.mass, NORMAL95 * evidence.spread.mass):
        return []
    text = (
        f"torques with payload that are {100 * hidden:.2g} % too large or too small, which these recordings do not "
        f"show ({whole.ratio:.3f} ± {whole.sigma:.2g} times those without), move this mass by "
        f"{100 * change / evidence.mass:.1f} %, out of its interval"
    )
    advice = f": --scale-sigma {100 * hidden:.2g}% allows for that" if evidence.weighed is None else ""
    return [note(text + advice, "mass")]


def motors_apart(evidence: Evidence) -> list[Finding]:
    """Currents of one motor with payload on another scale than without (`gains`).

    By over {JOINT_SCALE:.0%} and {OWN_SCALE_Z:g} sigma: spoils its gain.
    """
    off = [
        found
        for found in evidence.diagnosis.scales
        if found.joint and abs(found.ratio - 1.0) > JOINT_SCALE and OWN_SCALE_Z < abs(found.z) <= JOINT_SCALE_Z
    ]
    if evidence.gained is None or not off:
        return []
    worst = max(off, key=lambda found: abs(found.z))
    text = (
        f"motor {worst.joint}: its currents with payload are {worst.ratio:.2f} ± {worst.sigma:.2g} times those "
        "without: keep the maker's gain there"
    )
    return [warning(text, "gain")]
