"""Scales of torques: over the weight of the described links, of those with payload, and of the joints' payloads.

Free parameters take any sign and unit, so that no residual shows a wrong scale of all torques. That joints agree on
one payload is the test of drive gains and friction.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from ...common import Array
from ...model import Robot
from ...model.drives import DriveState
from ...model.friction import is_friction
from ...model.regressors import body_torques
from ...model.stand_in import nominal_bodies
from ..equations.equations import PAYLOAD, Equations
from ..fit.covariance import NORMAL95, few_blocks
from ..payload.by_joints import ByJoints
from ..payload.long_motion import LongMotion
from ..payload.methods import PayloadProblem
from .engine import BLOCKS, Added, Effect, States, System
from .evidence import Evidence, Finding, NominalGravity, error, note, warning
from .hypotheses import BY_NAME, EARTH, HELPFUL, WEIGHT, pull_of

UNIT = 3.0
"""Ratio of the torques to those by the description, or its inverse, above which they are in another unit. Bodies of
real arms' URDFs give 1.1 to 2.4, cylinders of the maker's mass .5 to 1; currents of a UR10e .09, of a Gen3 .2."""
GAIN = 2.5
"""Ratio of one joint over the median of all, or its inverse, above which its gain is another one; real arms' joints
are within 1.6."""
EXPLAINED, SURE, CARRIES = 0.5, 0.2, 0.05
"""From where on a joint shows its ratio: fraction of its squared torque that gravity explains, relative standard
deviation of the ratio, gravity torque over the largest joint's."""
LEANS, CLEARLY = 25.0, 0.1
"""Angle [degrees] from the described gravity to that of the torques above which the robot is mounted otherwise
(real arms are up to 10 off), and fraction of the squared torque that only another direction explains."""
SETTLED, SETTLED_Z = 0.6, 3.0
"""Fraction by which chi2 falls with a joint counted the other way or another robot, and Vuong's statistic, above
which that is the reason: .76 to 1 where it is so, .07 at most with torques of the wrong sign."""

_FLOOR = 1e-6  # of the squared torque: data without noise still need finite weights
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
NOTABLE, NOTABLE_SIGMAS = 0.03, 3.3
"""Relative difference of the mass between two joints that is reported, and its standard deviations."""
WRONG, SHARE = 0.10, 0.15
"""Relative difference of one joint's mass from the answer, and of its payload ratio from 1: real ones have 0.1."""
SIGMAS = 4.5  # standard deviations beyond which a difference is none by chance
CHANCE = (0.1, 0.01)
"""Probabilities that joints which agree disagree as much by chance: below the first intervals widen, below the
second by all of the disagreement."""
TOGETHER = 2.5  # factor by which all payload ratios together widen the intervals, above which it is reported
USEFUL = 0.10
"""Relative half-width of the mass's 95 % interval, grown by the joints' disagreement, above which it is useless."""


def nominal_gravity(robot: Robot, states: States | None) -> NominalGravity | None:
    """Compare torques, those without payload where there are any, with the weight of the described links.

    Beside friction, an offset and what accelerates links and rotor, each joint's torque is a multiple of the
    gravity torque by the described bodies, and of all joints together it is that of gravity in some direction.
    None for arms whose springs carry them, without gravity, bodies or motion.
    """
    size = float(np.linalg.norm(robot.gravity))
    if states is None or robot.spring is not None or not size or (nominal := nominal_bodies(robot)) is None:
        return None
    if not states.loaded.all():
        states = states.taken(states.loaded == 0.0)
    values, assumed = nominal
    # Torques of the weight along each axis, and of what accelerates the bodies without weight.
    q, qd, qdd = states.q.T, states.qd.T, states.qdd.T
    *axes, inertial = (
        np.array(body_torques(replace(robot, gravity=(x, y, z)), DriveState(q, m * qd, m * qdd, None), values, np))
        for x, y, z, m in np.diag([size, size, size, 1.0]).tolist()
    )
    along, described = np.stack(axes, axis=1), np.array(robot.gravity) / size
    expected, block, qd = described @ along, np.arange(len(states.t)) * BLOCKS // len(states.t), states.qd.T
    own = [np.ones(qd.shape), qd, np.sign(qd), states.qdd.T, inertial]
    rows = np.stack([*own, *along.swapaxes(0, 1), expected, states.torque.T], axis=1)
    rows *= (states.keep.T & (states.keep.sum(axis=0) >= BLOCKS)[:, None])[:, None]
    grams = [part @ part.swapaxes(1, 2) for part in (rows[:, :, block == b] for b in range(BLOCKS))]
    joints = [Added.of(each, np.zeros((len(own), len(own))), slice(0)) for each in np.swapaxes(grams, 0, 1)]
    # Each joint is weighted by what gravity in any direction leaves of its torque.
    squares, counts = np.array([one.whole[-1, -1] for one in joints]), rows[:, 0].sum(axis=1)
    left = np.maximum([1.0 - one.effect(range(3)).fall for one in joints], _FLOOR) * squares
    weights = np.where(left > 0.0, counts / np.where(left > 0.0, left, 1.0), 0.0)
    # A standard deviation by the formula is one of weighted rows.
    joints = [one._replace(whole=w * one.whole, left=w * one.left) for w, one in zip(weights, joints, strict=True)]
    whole, left_out = (np.sum(np.array([one[k] for one in joints]), axis=0) for k in range(2))
    gravity, each = Added(whole, left_out, joints[0].payload).effect(range(3)), [one.effect([3]) for one in joints]
    needed = np.linalg.norm(expected * states.keep.T, axis=1)
    shown = needed > CARRIES * needed.max()
    shown &= [one.fall > EXPLAINED and one.sigma < SURE * abs(one.size) for one in each]
    squares *= weights
    return NominalGravity(
        ratio=np.where(shown, [one.size for one in each], np.nan),
        gravity=size * gravity.values,
        gravity_sigma=size * gravity.sigma,
        explained=gravity.fall,
        by_joints=float(squares @ [one.fall for one in each]) / max(float(squares.sum()), 1e-300),
        assumed=assumed,
    )


def weight(evidence: Evidence) -> Iterator[Finding]:
    """A described gravity that is not Earth's.

    By over {WEIGHT:.0%}, if the torques are closer to Earth's: do not use.

    Torques against the weight of the links by the robot's description.

    Over {UNIT:g} times more or less, of the other sign, one joint's over {GAIN:g} times more or less than most, or
    gravity over {LEANS:g} degrees off: do not use, and explains the rest; only noted if the unit is given.
    Columns named effort that the weight of the links does not confirm: do not use until the unit is given.
    """
    shown, usual = evidence.effects.get("weight"), float(np.linalg.norm(evidence.robot.gravity))
    if shown is not None and not BY_NAME["weight"].stands_out(shown):
        more = EARTH / usual - 1.0
        if abs(more) > WEIGHT and abs(shown.size - more) < abs(shown.size):
            yield error(
                f"the robot's description has a gravity of {usual:.4g} m/s², but Earth's is {EARTH:g} and the "
                f"torques show {usual * (1.0 + shown.size):.3g} ± {usual * shown.sigma:.1g}: correct the "
                "description"
            )
    nominal, source = evidence.nominal, evidence.source
    units = {one.torque_unit for one in (*source.unloaded, *source.loaded)} if source is not None else set()
    # A joint counted the other way, or another robot, which goes against the weight too, leaves next to nothing.
    others = evidence.alternatives
    settled = any(one.kind in ("turned", "robot") and one.fall > SETTLED and one.z > SETTLED_Z for one in others)
    contradiction = _contradiction(evidence.robot, nominal) if nominal is not None and not settled else ""
    if contradiction and nominal is not None:
        bodies = f"link masses assumed: {nominal.assumed}" if nominal.assumed else "link masses as described"
        text = f"{contradiction} ({bodies})"
        yield note(text) if units == {"given"} else Finding("error", "everything", text, True, 1.0)
    elif "unknown" in units and (nominal is None or np.isnan(nominal.ratio).all()):
        yield error(
            "the unit of the log's effort columns is unknown, and the weight of the links does not show it: give "
            "--units tau=N·m if they are torques, else tau=A, tau=percent or tau=raw with --drive-gains"
        )


def _contradiction(robot: Robot, nominal: NominalGravity) -> str:
    """Say what does not go with the weight of the links; empty if all does."""
    size, length = float(np.linalg.norm(robot.gravity)), float(np.linalg.norm(nominal.gravity))
    cosine = float(nominal.gravity @ robot.gravity) / max(size * length, 1e-300)
    sure = nominal.gravity_sigma < SURE * length and nominal.explained > nominal.by_joints + CLEARLY
    if sure and cosine < np.cos(np.radians(LEANS)):
        x, y, z = np.round(size / length * robot.base.R.T @ nominal.gravity, 1) + 0.0
        return (
            f"the links' weight acts {np.degrees(np.arccos(cosine)):.0f} degrees away from the described gravity: "
            f"is the robot mounted differently? These data suggest --mount gravity={x:g},{y:g},{z:g}"
        )
    shown = np.flatnonzero(np.isfinite(nominal.ratio))
    if not len(shown):
        return ""
    ratio, joints = nominal.ratio[shown], np.array([str(j + 1) for j in shown])
    times = ", ".join(f"{value:.2g} (joint {j})" for j, value in zip(joints, ratio, strict=True))
    are = f"measured over expected from the links' weight: {times}"
    if (wrong := ratio < 0.0).all() and len(shown) > 1:
        return (
            f"all torques have the wrong sign for gravity ({are}): is the robot mounted upside down (--mount "
            "ceiling)? If not, reverse the sign of [torque] in a log map"
        )
    if wrong.any():
        return (
            f"the torque of joint {', '.join(joints[wrong])} has the wrong sign for gravity ({are}): reverse the "
            "sign of [torque] in a log map, or of its drive gain"
        )
    middle = float(np.median(ratio))
    if not 1.0 / UNIT < middle < UNIT:
        looks = "motor-side torques, currents, percent or kN·m" if middle < 1.0 else "mN·m, mA or counts"
        return (
            f"the torques look like {looks} ({are}): give their unit (--units tau=..) and --drive-gains, or "
            "[motor] gear_ratios in a log map. If they are right, --units tau=N·m says so"
        )
    off = (ratio < middle / GAIN) | (ratio > GAIN * middle)
    if off.any():
        return (
            f"the torque of joint {', '.join(joints[off])} has another scale than the others ({are}): check its "
            "drive gain and unit. If a spring carries the joint, describe it in the robot's file"
        )
    return ""


def scales(problem: PayloadProblem, weights: Array, system: System | None) -> tuple[Effect, ...]:
    """Estimate scales of the loaded torques, of all and of each joint; none where the scale is an unknown.

    Each is one more column of method 4 in the loaded rows: the rigid part of what the robot alone needs, friction
    of those rows free. All of it is in the joints' triangular factors, so that no row is read again; beside a robot
    that is known, and in a short motion, subsampled states do.
    """
    n, by_states = problem.robot.n, tuple[Effect, ...]()
    wheres = ["", *(f"joint {joint}" for joint in range(1, n + 1))]
    if system is not None:
        rigid = [k for k, name in enumerate(system.names) if not is_friction(name)]
        along = (system.values[rigid] @ system.columns[:, rigid]) * system.states.loaded
        prior = np.array(system.prior)
        prior[system.payload.stop :, system.payload.stop :] = 0.0  # friction under load is free
        added = system.with_columns(along[:, None], np.eye(n)[:, :, None] * along[:, None], prior=prior)
        by_states = tuple(added.effect([k], where=where) for k, where in enumerate(wheres))
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
    carried[friction], carried[rigid, unknown] = column[c:unknown], robot[rigid]
    of_joints = np.repeat(carried[None], n, axis=0)
    of_joints[:, rigid, unknown + 1 : -1] = np.eye(n)[:, None] * robot[rigid, None]

    def gram(block: Equations, changes: Iterable[Array]) -> Array:
        rows = np.vstack([w * R @ M for w, R, M in zip(weights, block.factors, changes, strict=True)])
        return np.asarray(rows.T @ rows)

    without = [gram(block, [own] * n) for block in unloaded.blocks]
    with_payload = [gram(block, of_joints) for block in loaded.blocks]
    # Blocks of one motion are left out together.
    together = len(without) == len(with_payload)
    blocks = np.add(without, with_payload) if together else np.array([*without, *with_payload])
    added = Added.of(blocks, np.zeros((unknown, unknown)), slice(b, c))
    # The limits were measured with these blocks, however few: none of 111 good recordings passes them. What they
    # take off is compared with that of hypotheses, which go by states.
    falls = [one.fall for one in by_states] or [0.0] * len(wheres)
    found = (added.effect([k], where=where) for k, where in enumerate(wheres))
    return tuple(one._replace(few=1.0, fall=fall) for one, fall in zip(found, falls, strict=True))


def scale(evidence: Evidence) -> Iterator[Finding]:
    """Loaded torques on a different scale from the unloaded ones, all or one joint's.

    All by {SCALE:.0%} and {SCALE_Z:g} sigma, or one joint's by {JOINT_SCALE:.0%} and {JOINT_SCALE_Z:g} sigma, and
    more clearly than a pull: do not use. Both are named if the data hardly distinguish them.

    Mass that an unnoticed scale error of the loaded torques would move out of its interval. An error of 1.96 sigma,
    {HIDDEN[0]:.0%} to {HIDDEN[1]:.0%}, moves it by over {SENSITIVE:.0%}: do not use if intervals grow by over
    {TOGETHER:g} (Birge), else noted; not if a different scale is seen, something pulls at the flange, or the
    payload was weighed.
    """
    found, pull = sorted(evidence.scales, key=Effect.z, reverse=True), pull_of(evidence)
    off = [scale for scale in found if beyond(scale)]
    if off and (pull is None or pull.z() <= off[0].z()):
        worst = off[0]
        either = [scale for scale in off if scale.z() > EITHER * worst.z()]
        others = [scale for scale in either if bool(scale.where) != bool(worst.where)]
        likely = sorted([worst, *others[:1]], key=lambda scale: scale.where)  # that of all torques first
        whose = f"{worst.where}'s torques" if worst.where else "the torques"
        whose = f"all torques, or only those of {likely[1].where}," if others else whose
        masses = " or ".join(f"{(evidence.mass + scale.change[9]) / (1.0 + scale.size):.3g}" for scale in likely)
        ratios = " or ".join(f"{1.0 + scale.size:.3f} ± {scale.sigma:.2g}" for scale in likely)
        text = (
            f"the scale of {whose} changes by a factor of {ratios} with payload; without this change the mass "
            f"would be {masses} kg: check units and drive gains, and what changed between the recordings"
        )
        yield error(text)._replace(cause=worst.fall > HELPFUL, explains=worst.fall)
    mass, whole = evidence.mass, next((scale for scale in evidence.scales if not scale.where), None)
    weighed = any(payload.result.weighings for payload in evidence.constrained) or pull is not None
    weighed = weighed or (evidence.weighed is not None and evidence.weighed.from_scale)
    if whole is None or evidence.spread is None or weighed or not mass > 0.0 or beyond(whole):
        return
    hidden = float(np.clip(NORMAL95 * whole.sigma, *HIDDEN))
    change = hidden * abs(mass - float(whole.effect[9, 0]))
    if change > max(SENSITIVE * mass, NORMAL95 * evidence.spread.mass):
        advice = f"; --scale-sigma {100 * hidden:.2g}% allows for it" if evidence.weighed is None else ""
        apart = evidence.disagreement > TOGETHER
        yield (error if apart else note)(
            f"{'the joints disagree about the payload, and ' if apart else ''}a scale error of {100 * hidden:.2g} "
            f"% in the torques with payload would go unnoticed (measured scale {1.0 + whole.size:.3f} ± "
            f"{whole.sigma:.2g}) and shift the mass by {100 * change / mass:.1f} %, out of its interval{advice}",
            "mass",
        )


def beyond(scale: Effect) -> bool:
    """True if a scale is another one."""
    least, z = (JOINT_SCALE, JOINT_SCALE_Z) if scale.where else (SCALE, SCALE_Z)
    return abs(scale.size) > least and scale.z() > z


def joints(evidence: Evidence) -> list[Finding]:
    """Joints that measure different payloads, because of drive gains or friction.

    A ratio off by {SHARE:.0%}, a mass by {WRONG:.0%} (and {SIGMAS:g} sigma), two masses apart by {NOTABLE:.0%} and
    {NOTABLE_SIGMAS:g} sigma. Every interval grows by the disagreement (Birge). Do not use if that of the mass is
    then over {USEFUL:.0%}, or if leaving the joint out moves the mass out of it; else not the inertia. A note if
    the intervals grow by more than {TOGETHER:g}.
    """
    view, mass, factor = evidence.by_joints, evidence.mass, evidence.disagreement
    # Standard deviations from few blocks, which are uncertain themselves, are wider, as Student's t is.
    wider = 1.0 if evidence.weighed is None else few_blocks(view.degrees_of_freedom)
    ratios = [(joint, ratio, wider * sigma) for joint, ratio, sigma in view.ratios]
    off = [each for each in ratios if abs(each[1] - 1.0) > max(SHARE, SIGMAS * each[2])]
    single = [
        (r.mass, wider * r.sigma, r.joints[0]) for r in view.masses if not r.joints[1:] and r.mass is not None
    ]
    apart = [each for each in single if abs(each[0] - mass) > max(WRONG * abs(mass), SIGMAS * each[1])]
    if not apart:
        pairs = [
            (abs(a[0] - b[0]) / np.hypot(a[1], b[1]), [a, b])
            for a, b in combinations(single, 2)
            if abs(a[0] - b[0]) > NOTABLE * abs(mass)
        ]
        z, pair = max(pairs, key=lambda entry: entry[0], default=(0.0, []))
        apart = pair if z >= NOTABLE_SIGMAS else []
    serious = bool(off or apart)
    if off:  # what it spoils in the others is its doing too
        joint, ratio, sigma = max(off, key=lambda each: abs(np.log(max(each[1], 0.05))))
        odd = [joint]
        text = f"joint {joint} measures {ratio:.2f} ± {sigma:.2g} times the payload that the other joints measure"
    elif apart:
        texts = ", ".join(f"joint {joint} {m:.3g} ± {s:.2g} kg" for m, s, joint in apart)
        odd = [joint for *_, joint in sorted(apart, key=lambda each: -abs(each[0] - mass) / each[1])]
        text = f"the joints measure different masses ({texts})"
    elif factor > TOGETHER and ratios:
        odd = [max(ratios, key=lambda each: abs(each[1] - 1.0) / each[2])[0]]
        text = (
            f"the joints disagree about the payload by {factor:.1f} times their errors, joint {odd[0]} most of all"
        )
    else:
        return []
    own = float(evidence.best.estimate.larger_sigma[9]) if evidence.best is not None else np.inf
    # Of drive gains nothing has widened the estimate yet.
    half = NORMAL95 * (evidence.spread.mass if evidence.spread is not None else factor * own)
    spoilt, advice = list[str](), "check its drive gain and friction"
    if not half <= USEFUL * abs(mass):
        spoilt.append(f"an interval that covers all joints is ± {100 * half / max(abs(mass), 1e-300):.0f} %")
    for joint in odd:
        without = next((reading for reading in view.without if joint not in reading.joints), None)
        if without is None or without.mass is None:
            spoilt += [f"without joint {joint} the mass is unknown"] if serious else []
        elif abs(without.mass - mass) > half + NORMAL95 * wider * without.sigma:
            spoilt.append(f"without joint {joint} the mass is {without.mass:.3g} ± {wider * without.sigma:.2g} kg")
    if spoilt:
        return [error(f"{text}; {spoilt[0]}: {advice}")]
    grown = f"every interval is {factor:.1f} times wider to allow for it"
    return [(warning if serious else note)(f"{text}; {grown}: {advice}")]


def disagreement(by_joints: ByJoints, gains: Array, few: bool = False) -> float:
    """Birge ratio of the joints' payload ratios: how much farther they lie from 1 than their errors let them.

    Joints that disagree prove an error of some gain, friction or description, of which no residual knows. What
    chance brings about widens nothing (F test). ``gains``: covariance of the gains' stated relative errors, n x n;
    what all joints have in common does not count. ``few``: whether standard deviations come from few blocks.
    """
    wider, k = few_blocks(by_joints.degrees_of_freedom) if few else 1.0, len(by_joints.ratios)
    if k < 2:
        return 1.0
    joint, ratio, sigma = np.array(by_joints.ratios).T
    index = joint.astype(int) - 1
    apart = (np.eye(k) * k - 1.0) / (k - 1)  # each less the others' mean
    variance = np.diag(apart @ gains[np.ix_(index, index)] @ apart.T)
    square = float(np.sum((ratio - 1.0) ** 2 / ((wider * sigma) ** 2 + variance)))
    freedom = float("inf") if few else by_joints.degrees_of_freedom
    first, last = CHANCE
    proven = np.clip((first - fdtrc(k, min(freedom, 1e9), square / k)) / (first - last), 0.0, 1.0)
    return 1.0 + float(proven) * (float(np.sqrt(max(1.0, square / (k - 1)))) - 1.0)


def worst_joint(by_joints: ByJoints, mass: float) -> str | None:
    """Describe the joint that agrees least with the answer's mass [kg] or the others; None where none can tell."""
    times = "times the torque that the other joints predict"
    readings = [
        (abs(ratio - 1.0) / sigma, joint, f"joint {joint} measures {ratio:.3f} ± {sigma:.2g} {times}")
        for joint, ratio, sigma in by_joints.ratios
    ]
    readings += [
        (abs(r.mass - mass) / r.sigma, r.joints[0], f"{r.name} alone measures {r.mass:.4g} ± {r.sigma:.2g} kg")
        for r in by_joints.masses
        if len(r.joints) == 1 and r.mass is not None
    ]
    return max(readings)[2] if readings else None
