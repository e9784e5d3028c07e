"""Torques against the weight of the links by the robot's own description: their unit, sign, gains and mounting.

Beside friction, an offset and what accelerates links and rotor, each joint's torque is a multiple of the gravity
torque by these bodies, and of all joints together it is that of gravity in some direction. Free parameters take any
sign and unit, so that no residual shows either.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...model import INERTIAL, Robot
from ...model.drives import parameter_kind
from ...model.regressors import regressor_at, standard_columns
from ...model.stand_in import can_stand_in, nominal_bodies
from .engine import Added
from .evidence import Evidence, NominalGravity
from .finding import Finding, error, note
from .states import BLOCKS, States

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


def nominal_gravity(robot: Robot, states: States | None) -> NominalGravity | None:
    """Compare torques, those without payload where there are any, with the weight of the described links.

    None for arms whose springs carry them, without gravity, bodies or motion.
    """
    size = float(np.linalg.norm(robot.gravity))
    if states is None or robot.spring is not None or not size or not can_stand_in(robot):
        return None
    if not states.loaded.all():
        states = states.taken(states.loaded == 0.0)
    values, assumed = nominal_bodies(robot)
    names = [name for name in standard_columns(robot) if parameter_kind(name) in INERTIAL]
    bodies, columns = np.array([values[name] for name in names]), []
    # Torques of the weight along each axis, and of what accelerates the bodies without weight.
    for x, y, z, moves in np.diag([size, size, size, 1.0]).tolist():
        turned = replace(robot, gravity=(x, y, z))
        columns.append(bodies @ regressor_at(turned, names, states.q, moves * states.qd, moves * states.qdd))
    *axes, inertial = columns
    along, described = np.stack(axes, axis=1), np.array(robot.gravity) / size
    expected, block, joints = described @ along, np.arange(len(states.t)) * BLOCKS // len(states.t), []
    for j, qd in enumerate(states.qd.T):
        own = np.vstack([np.ones(len(qd)), qd, np.sign(qd), states.qdd[:, j], inertial[j]])
        rows = np.vstack([own, along[j], expected[j], states.torque[:, j]])
        rows *= states.keep[:, j] & (states.keep[:, j].sum() >= BLOCKS)
        grams = np.array([part @ part.T for part in (rows[:, block == b] for b in range(BLOCKS))])
        added = Added.of(grams, np.zeros((len(own), len(own))), slice(0))
        # Each joint is weighted by what gravity in any direction leaves of its torque.
        left = max(1.0 - added.effect(range(3)).fall, _FLOOR) * float(added.whole[-1, -1])
        weight = float(np.sum(rows[0])) / left if left > 0.0 else 0.0
        joints.append(added._replace(whole=weight * added.whole, left=weight * added.left))
    each = [one.effect([3]) for one in joints]
    whole, left_out = (np.sum(np.array([one[k] for one in joints]), axis=0) for k in range(2))
    gravity = Added(whole, left_out, joints[0].payload).effect(range(3))
    needed = np.linalg.norm(expected * states.keep.T, axis=1)
    shown = needed > CARRIES * needed.max()
    shown &= [one.fall > EXPLAINED and one.sigma < SURE * abs(one.size) for one in each]
    squares = np.array([float(one.whole[-1, -1]) for one in joints])
    return NominalGravity(
        ratio=np.where(shown, [one.size for one in each], np.nan),
        gravity=size * gravity.values,
        gravity_sigma=size * gravity.sigma,
        explained=gravity.fall,
        by_joints=float(squares @ [one.fall for one in each]) / max(float(squares.sum()), 1e-300),
        assumed=assumed,
    )


def weight(evidence: Evidence) -> Iterator[Finding]:
    """Torques against the weight of the links by the robot's description.

    Over {UNIT:g} times more or less, of the other sign, one joint's over {GAIN:g} times more or less than most, or
    gravity over {LEANS:g} degrees off: do not use, and explains the rest; only noted if the unit is given.
    Columns named effort that the weight of the links does not confirm: do not use until the unit is given.
    """
    nominal, source = evidence.diagnosis.nominal, evidence.source
    units = {one.torque_unit for one in (*source.unloaded, *source.loaded)} if source is not None else set()
    # A joint counted the other way, or another robot, which goes against the weight too, leaves next to nothing.
    others = evidence.diagnosis.alternatives
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
