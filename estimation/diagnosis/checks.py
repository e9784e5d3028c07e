"""The table of checks on fits and answers: each a generator from the evidence to its findings.

The first sentence of a docstring says what is checked, the rest from where on and what that spoils; docs/verdict.md
prints them.
"""

from collections.abc import Iterator
from itertools import combinations
from math import hypot

import numpy as np

from ...common import Array
from ...model.inertia import PayloadSpread
from ..fit.covariance import NORMAL95
from ..fit.estimate import Fit
from ..possible.constraints import PossibleBody
from ..possible.payload import CONFLICT
from .engine import Effect
from .evidence import KNOWN_WELL, UNFREED, Evidence, Finding, Judged, error, note, warning
from .scales import JOINT_SCALE, JOINT_SCALE_Z, OWN_SCALE_Z

MASS_SIGMA = 0.05  # relative standard deviation of the mass above which nothing should be used
COM_SIGMA, COM_FLOOR = 0.3, 0.02
"""Standard deviation of the centre of mass, of the payload's own size, above which it should not be used; one known
to the second [m] is good whatever the payload's size."""
INERTIA_SIGMA = 0.30
"""Relative standard deviation of a moment of inertia at the centre of mass above which it should not be used."""
RESIDUAL, JOINT_RESIDUAL = 0.25, 0.5
"""Relative residual of all joints, and of one, above which the model does not describe them: on real and on noisy
simulated robots good joints stay under 0.36."""
SHORTEST = 3.0  # s
NOISE, FLOOR = 0.01, 3.0
"""Noise that a joint may have over the largest torque's rms of its kind where none is measured (real ones: 0.5 to
0.9 % of limits), and errors over its measured white noise."""
LOADED_RATIO = 3.0
"""Relative residual with payload over that without, above which the two recordings do not belong together."""
VALIDATION_RATIO, VALIDATION_FLOOR, VALIDATION = 1.5, 0.06, 0.20
"""Relative residual on held-out recordings over that of the fit above which the model does not carry over: real
ones have up to 1.3. One below the second is good whatever the ratio, one above the third is not."""
MISMATCH = 0.005
"""Difference of positions [rad or m, rms] of a pair that is not one motion; real pairs lie below 2e-4."""
DRIVEN_SIGMAS = 5.0  # standard deviations below zero at which friction counts as negative
MASS_SPREAD, METHODS_APART = 0.05, 0.02
"""Relative spread of the mass over the methods, and difference of two that also exceeds their intervals."""
SIGMAS = 4.0  # standard deviations beyond which a difference is none by chance
ROUNDED = 0.02
"""Fraction by which a mass may pass the rated payload: data sheets round, and a given mass may be the rated one."""
OTHER_WAY = 0.05  # relative difference of a weighing's mass by another way that speaks against all numbers
CONDITION = 500.0
"""Condition number with columns scaled above which small errors spoil the answer; good motions have 10."""
_MOMENTS = "XX", "YY", "ZZ"
STILL: Judged = "not visible", "standing still does not excite it"  # use of an inertia by a weighing at rest
SWINGS, CLEAR, MATTERS = 3.0, 5.0, 0.02
"""Oscillation of the loaded torque at rest over that without payload, over the median of other frequencies, and
over the payload's largest torque, above which the payload swings."""
HOLDS, CARRIES = 0.1, 0.2
"""Spread of a joint's torque from rest to rest over that on the way there, below which a brake holds it; and spread
on the way there, over the largest joint's, below which a joint says nothing."""
IMPOSSIBLE = "possible robot"  # what its finding is about
APART, APART_SIGMAS = 0.03, 4.0
"""Difference of two weights' ratio from the nominal one, and its standard deviations, above which one is wrong."""


def judged(ten: Array, moments: Array, spread: PayloadSpread, from_scale: bool = False) -> dict[str, Judged]:
    """Judge mass, centre of mass and inertia at it, by half their 95 % intervals over 1.96, ``spread``.

    The ten parameters are nan where unknown, the spread is infinite where the joints show nothing. The centre of
    mass is allowed 20 mm, or 0.3 of the payload's radius of gyration about the frame's origin. ``moments``: of
    inertia at the centre of mass, shape (3,); ``from_scale``: whether the mass is a scale's.
    """
    known = bool(np.isfinite(ten).all() and ten[9] > 0.0)
    size = float(np.sqrt(max(ten[[0, 3, 5]].sum(), 0.0) / 2.0 / ten[9])) if known else 0.0
    (sigma, axis), allowed = max(zip(spread.com, "xyz", strict=True)), max(COM_FLOOR, COM_SIGMA * size)
    parts = [spread.mass / max(abs(ten[9]), 1e-300), *(spread.moments / np.maximum(moments, 1e-300))]
    mass, *texts = (f"{100 * part:.0f} %" if part < 10.0 else "over 1000 %" for part in parts)
    inertia = zip(_MOMENTS, texts, parts[1:], strict=True)
    wide = ", ".join(f"{text} of {name}" for name, text, part in inertia if not part <= INERTIA_SIGMA)
    vague = {
        "mass": f"is {mass} (limit {100 * MASS_SIGMA:.0f} %); move joint 2 or 3, use a wider range, record longer, "
        "or weigh the payload",
        "centre of mass": f"along {axis} is {1e3 * sigma:.0f} mm (limit {1e3 * allowed:.0f} mm); turn the wrist "
        "farther, or weigh the payload",
        "inertia": f"is {wide} (limit {100 * INERTIA_SIGMA:.0f} %); move the wrist faster, or record longer",
    }
    answer: dict[str, Judged] = {
        quantity: ("use", "") if enough else ("not measured well enough", f"1 sigma {text}")
        for (quantity, text), enough in zip(
            vague.items(), (parts[0] <= MASS_SIGMA, sigma <= allowed, not wide), strict=True
        )
    }
    for quantity, names, sigmas in (("centre of mass", "xyz", spread.com), ("inertia", _MOMENTS, spread.moments)):
        if hidden := [name for name, s in zip(names, sigmas, strict=True) if not np.isfinite(s)]:
            answer[quantity] = "not visible", f"these joints do not show {', '.join(hidden)}"
    if from_scale:
        answer["mass"] = "weighed", "the torques of these joints do not show it"
    return answer


def relative_per_joint(fit: Fit, evidence: Evidence) -> Array:
    """Relative residual of each joint, shape (n,); 0 where what is left is no more than a torque's noise.

    A joint that carries next to no torque, such as the last one of an arm with sensors on the link side, leaves
    nearly all of it unexplained by noise alone: its own norm cannot judge it.
    """
    root, white = np.sqrt(np.maximum(np.array(fit.rows), 1)), evidence.white_noise
    turns = np.array([joint.revolute for joint in evidence.robot.joints])
    kind = turns[:, None] == turns
    noise = NOISE * np.max(kind * (fit.torque_norms / root), axis=1) if white is None else FLOOR * white
    return np.asarray(np.where(fit.error_norms / root <= noise, 0.0, fit.relative_per_joint))


def too_short(evidence: Evidence) -> Iterator[Finding]:
    """Recordings that are too short. Under {SHORTEST:g} s in all, without or with payload: do not use."""
    kinds = (evidence.source.unloaded, evidence.source.loaded) if evidence.source is not None else ()
    seconds = min((sum(float(np.ptp(one.t)) for one in own) for own in kinds if own), default=SHORTEST)
    if seconds < SHORTEST:
        yield error(f"{seconds:.2g} s of recording is too short: record 20 s or more")


def residual(evidence: Evidence) -> Iterator[Finding]:
    """Residual without payload, and with it.

    Over {RESIDUAL:.0%} for all joints, over {JOINT_RESIDUAL:.0%} for one, or with payload over {LOADED_RATIO:g}
    times that without: do not use.

    Residual of the robot's model on held-out recordings. Over {VALIDATION:.0%}: do not use; over
    {VALIDATION_RATIO:g} times the fit's, {VALIDATION_FLOOR:.0%} and what white noise explains: not the inertia.
    """
    if evidence.parameters is None:
        return
    # The residual of method 3 is that of a torque difference.
    modelled = [estimate for estimate in evidence.estimates if estimate.method != 3]
    fits = {"the model" if evidence.of_robot else "the robot's model without payload": evidence.parameters.fit}
    fits |= {f"method {estimate.method}": estimate.estimate.fit for estimate in modelled}
    for subject, fit in fits.items():
        left, text = relative_per_joint(fit, evidence), ""
        joints = ", ".join(str(j) for j, relative in enumerate(left, 1) if not relative <= JOINT_RESIDUAL)
        if not fit.relative <= RESIDUAL:
            text = (
                f"{100 * fit.relative:.0f} % of the torque unexplained: check units, signs, the order of the "
                "joints, and drive gains"
            )
        elif joints:
            text = (
                f"up to {100 * np.max(left):.0f} % of the torque of joint {joints} unexplained: check its sign, "
                "unit and drive gain, and whether it moved enough"
            )
        if any(fit.rows) and text:
            yield error(f"{subject} leaves {text}")
            break
    own, held_out, white = evidence.parameters.fit.relative, evidence.validation, evidence.white_noise
    if apart := [e for e in modelled if e.estimate.fit.relative > LOADED_RATIO * max(own, 0.01)]:
        worst, numbers = max(e.estimate.fit.relative for e in apart), ", ".join(str(e.method) for e in apart)
        which = f"each of methods {numbers}" if apart[1:] else f"method {numbers}"
        yield error(
            f"{which} leaves {100 * worst:.0f} % of the torque with payload unexplained, but only "
            f"{100 * own:.1f} % without: check signs, and that both recordings are of the same robot"
        )
    if held_out is None:
        return
    unseen, rows = held_out.relative, np.sqrt(held_out.rows)
    noise = (
        0.0
        if white is None
        else FLOOR * float(np.linalg.norm(white * rows) / np.linalg.norm(held_out.torque_norms))
    )
    if unseen > VALIDATION or unseen > max(VALIDATION_FLOOR, VALIDATION_RATIO * own, noise):
        yield (error if unseen > VALIDATION else warning)(
            f"the robot's model leaves {100 * unseen:.0f} % of the torque of the validation recording unexplained, "
            f"but {100 * own:.1f} % of the fitted one: it does not carry over to other motions; excite all joints "
            "over their whole range"
        )


def parameters(evidence: Evidence) -> Iterator[Finding]:
    """Friction that drives its joint instead of braking.

    Coulomb and load-dependent friction over {DRIVEN_SIGMAS:g} sigma below zero: do not use. Viscous: a note.

    Parameters that no physical robot has. p below {CONFLICT:g}: a warning; do not use if anything else looks wrong.
    """
    driven, falls = list[str](), list[str]()
    if (own := evidence.parameters) is not None:
        loads = own.fit.torque_norms / np.sqrt(np.maximum(own.fit.rows, 1))
        covariances = [own.covariance, *([] if own.robust is None else [own.robust.covariance])]
        # A term by the root of speed, or of Stribeck, takes the place of Coulomb friction.
        for j in (j for j in range(1, len(loads) + 1) if not {f"FR{j}", f"FB{j}"} & {*own.names}):
            for found, terms in ((driven, {f"FS{j}": 1.0, f"FL{j}": loads[j - 1]}), (falls, {f"FV{j}": 1.0})):
                along = np.array([terms.get(name, 0.0) for name in own.names])
                if along @ own.values < -DRIVEN_SIGMAS * np.sqrt(max(along @ C @ along for C in covariances)):
                    found.append(str(j))
                    break
    if driven:
        yield error(
            f"the friction of joint {', '.join(driven)} comes out negative, as if it drove the joint: check the "
            "signs of its torque and position, and whether the column holds a torque (not a current or percent)"
        )
    if falls:
        yield note(f"the friction of joint {', '.join(falls)} falls with speed (negative viscous friction)")
    if evidence.possible is not None and evidence.possible < CONFLICT:
        unlikely = f"no physical robot can have these parameters (p {evidence.possible:.2g})"
        yield warning(f"{unlikely}: check the robot's description, signs, units and drive gains", IMPOSSIBLE)


def masses(evidence: Evidence) -> Iterator[Finding]:
    """Mass that is negative or zero. Less than {SIGMAS:g} sigma above zero: do not use.

    Methods that disagree about the mass. Spread over more than {MASS_SPREAD:.0%}, or two apart by
    {METHODS_APART:.0%} and {SIGMAS:g} sigma: do not use.
    """
    shown = [(f"method {e.method}", e.mass, float(e.estimate.larger_sigma[9])) for e in evidence.estimates]
    if evidence.weighed is not None and not evidence.weighed.from_scale:
        shown.append(("the torque", evidence.weighed.mass, evidence.weighed.sigma))
    little = [(who, mass, sigma) for who, mass, sigma in shown if not mass > SIGMAS * sigma]
    negative = [entry for entry in little if entry[1] < -SIGMAS * entry[2]]
    texts = ", ".join(f"{mass:.3g} ± {sigma:.2g} kg by {who}" for who, mass, sigma in negative or little)
    if negative:
        yield error(
            f"the mass is negative ({texts}): check that the recordings with and without payload are not swapped, "
            "and the signs of torques and gravity",
            "mass",
        )
    elif little:
        light = all(mass + SIGMAS * sigma < evidence.robot.rated_payload for _, mass, sigma in little)
        advice = "was the payload really on?" if light else "move faster and farther, or record longer"
        yield error(f"the mass cannot be told from zero ({texts}): {advice}", "mass")
    found = [e.mass for e in evidence.estimates] or [0.0]
    mean, text = abs(float(np.mean(found))), ""
    for a, b in combinations(evidence.estimates, 2):
        chance = SIGMAS * hypot(a.estimate.larger_sigma[9], b.estimate.larger_sigma[9])
        if not text and abs(a.mass - b.mass) > max(METHODS_APART * mean, chance):
            beyond = f"methods {a.method} and {b.method} disagree beyond their intervals"
            text = f"{beyond}: {a.mass:.4g} and {b.mass:.4g} kg"
    if np.ptp(found) > MASS_SPREAD * mean:
        text = f"the methods' masses range from {min(found):.3g} to {max(found):.3g} kg"
    if text:
        yield error(f"{text}: did friction or anything else change between the recordings?", "mass")


def measured(evidence: Evidence) -> Iterator[Finding]:
    """Mass, centre of mass and inertia that are not measured well enough.

    Sigma of the mass over {MASS_SIGMA:.0%}, of the centre of mass over {COM_FLOOR:g} m and over {COM_SIGMA:g} of
    the payload's own size: do not use; of a moment at the centre of mass over {INERTIA_SIGMA:.0%}: not the inertia.

    Torque that payload, friction and the recording without payload leave unexplained (`weigh`). Over
    {JOINT_RESIDUAL:.0%} of a joint's torque: do not use.
    """
    for quantity, (use, why) in evidence.judged.items():
        if use not in ("use", "weighed"):
            against = warning if quantity == "inertia" else error
            yield against(f"the {quantity} is {use}: {why}", quantity)
    left = evidence.unexplained
    joints = ", ".join(str(j) for j, relative in enumerate(left, 1) if relative > JOINT_RESIDUAL)
    if joints:
        yield error(
            f"up to {100 * np.nanmax(left):.0f} % of the torque of joint {joints} is unexplained: check its "
            "sign, unit and drive gain, and that both recordings are of the same motion"
        )


def new_zeros(evidence: Evidence) -> Iterator[Finding]:
    """Positions of a pair that differ by a constant.

    By over 2 mrad, if the rest of the difference is below 10 mrad and a fifth of that: do not use.
    """
    for pair in evidence.source.compared if evidence.source is not None else ():
        for j in pair.new_zeros:
            yield error(
                f"q{j + 1} of {pair.loaded.source} differs from that of {pair.unloaded.source} by a constant "
                f"{1e3 * pair.constant[j]:+.1f} mrad or mm: was the encoder re-zeroed in between?"
            )


def other_ways(evidence: Evidence) -> Iterator[Finding]:
    """Cross-checks of the mass (`weigh`). Over {OTHER_WAY:.0%} off: do not use.

    A mass that changes steadily from recording to recording (`weigh`). A trend with p below 0.05 that leaves the
    mass's interval: do not use. Within it: a note.
    """
    mass, repeats = evidence.mass, evidence.repeats
    for way in evidence.agreement:
        if way.name != UNFREED and abs(way.mass - mass) > OTHER_WAY * abs(mass):
            yield error(f"the {way.name} gives a mass of {way.mass:.4g} kg, not {mass:.4g} kg", "mass")
    if repeats is None or not repeats.drifts:
        return
    step, sigma = repeats.drift_per_recording or 0.0, repeats.drift_sigma or 0.0
    text = f"the mass drifts by {step:+.3g} ± {sigma:.2g} kg from recording to recording: warm the robot up first"
    across = abs(step) * (len(repeats.masses) - 1)
    if evidence.spread is not None and across <= 2.0 * NORMAL95 * evidence.spread.mass:
        yield note(f"{text}; the interval of the mass allows for it", "mass")
    else:
        yield error(text, "mass")


def rests(evidence: Evidence) -> Iterator[Finding]:
    """Poses reached from one side only, a payload that swings, and brakes that hold (`weigh --static`).

    Torque at rest that oscillates over {SWINGS:g} times as far as without payload, {CLEAR:g} times as far as at
    other frequencies and {MATTERS:.0%} of the payload's torque, or varies by under {HOLDS:.0%} of what it does on
    the way there: do not use.
    """
    if (problem := evidence.at_rest) is None:
        return
    from ..payload.static import oscillation

    bare, held = len(problem.source.unloaded), np.zeros(problem.robot.n, dtype=bool)
    for own in problem.rests:
        held |= (own.moving > CARRIES * own.moving.max()) & (own.torque.std(axis=0) < HOLDS * own.moving)
    (frequencies, earlier), (_, size) = oscillation(problem.rests[:bare]), oscillation(problem.rests[bare:])
    largest = (problem.loaded.torque_norms / np.sqrt(np.maximum(problem.loaded.rows, 1))).max()
    k, j = np.unravel_index(int(np.argmax(size * (size > SWINGS * earlier))), size.shape)
    if problem.one_sided:
        yield error(
            f"pose {', '.join(map(str, problem.one_sided))} is reached from one side only, so friction cannot be "
            "told from weight: reach each pose from both sides ('dynident near --static')"
        )
    if joints := [str(joint) for joint in problem.joints if held[joint - 1]]:
        yield error(
            f"the torque of joint {', '.join(joints)} at rest is the same in all poses, though not while moving: a "
            "brake holds the arm, so no torque shows its weight. Record with the brakes open"
        )
    elif size[k, j] > max(SWINGS * earlier[k, j], CLEAR * np.median(size[:, j]), MATTERS * largest):
        yield error(
            f"the payload swings: at rest the torque of joint {j + 1} oscillates at {frequencies[k]:.1f} Hz by "
            f"{size[k, j]:.2g} N·m or N (rms; without payload {earlier[k, j]:.2g}). Wait longer, or fasten it"
        )


def excitation(evidence: Evidence) -> Iterator[Finding]:
    """Pairs whose positions differ, so that method 3 does not fit. Over {MISMATCH:g} rad (rms): not the inertia.

    Nearly dependent equations. Condition number over {CONDITION:g} with columns scaled: not the inertia.
    """
    worst = max(evidence.pairs, key=lambda pair: pair.rms_mismatch, default=None)
    if worst is not None and worst.rms_mismatch > MISMATCH:
        yield warning(
            f"{worst.unloaded.source} and {worst.loaded.source} differ by {1e3 * worst.rms_mismatch:.1f} mrad "
            "(rms) after alignment, but method 3 needs the same motion: record it again, or use method 4"
        )
    if evidence.condition is not None and evidence.condition > CONDITION:
        yield warning(
            f"the equations are nearly dependent (condition number {evidence.condition:.0f}, columns scaled): "
            "move more joints at once, over a wider range"
        )


def gains(evidence: Evidence) -> Iterator[Finding]:
    """Known weights whose masses contradict each other (`gains`).

    By {APART:.0%} and {APART_SIGMAS:g} sigma: do not use.

    Gains that are not well determined (`gains`). Over {KNOWN_WELL:.0%}: do not use these gains.

    Currents of one motor with payload on a different scale from those without (`gains`). By over {JOINT_SCALE:.0%}
    and {OWN_SCALE_Z:g} sigma: not its gain.
    """
    apart = []
    for pair in combinations(evidence.weights, 2):
        first, second = (mass / nominal for _, nominal, mass, _ in pair)
        off, chance = abs(first / second - 1.0), hypot(*(sigma / mass for *_, mass, sigma in pair))
        if off > max(APART, APART_SIGMAS * chance):
            apart.append((off / chance, pair))
    if apart:
        told = " and ".join(
            f"mounting {name} comes out as {mass:.4g} ± {sigma:.2g} kg but was given as {nominal:g} kg"
            for name, nominal, mass, sigma in max(apart)[1]
        )
        yield error(
            f"the known weights contradict each other: with these gains {told}. Check the masses given, and that "
            "--mounting groups the recordings correctly",
            "mass",
        )
    sigma = evidence.gained if evidence.gained is not None else np.zeros(0)
    if vague := [(str(j), f"{100 * s:.2g}") for j, s in enumerate(sigma, 1) if not s <= KNOWN_WELL]:
        names, parts = (", ".join(column) for column in zip(*vague, strict=True))
        text = f"motor {names}: the gain is known only to {parts} % (1 sigma)"
        farther = "use a heavier weight, off the flange's axis, and move faster, farther or longer"
        some = len(vague) < len(sigma)
        yield warning(f"{text}; keep the maker's gain there", "gain") if some else error(f"{text}; {farther}")
    own = [scale for scale in evidence.scales if scale.where and abs(scale.size) > JOINT_SCALE]
    own = [scale for scale in own if OWN_SCALE_Z < scale.z() <= JOINT_SCALE_Z]  # beyond the second it spoils all
    if evidence.gained is not None and own:
        worst = max(own, key=Effect.z)
        yield warning(
            f"motor {worst.where.split()[1]}: the scale of its currents with payload is {1.0 + worst.size:.2f} ± "
            f"{worst.sigma:.2g} times that without; keep the maker's gain there",
            "gain",
        )


def conflicts(evidence: Evidence) -> Iterator[Finding]:
    """A mass above the rated payload. If its whole interval lies above, and by over {ROUNDED:.0%}: do not use.

    Constraints and weighed masses that contradict the data, and answers on a bound. p below 0.01 by the robust
    variance: do not use. An answer on a bound that you gave: not the inertia.
    """
    rated, sigma = evidence.robot.rated_payload, evidence.spread.mass if evidence.spread is not None else 0.0
    if evidence.mass - NORMAL95 * sigma > (1.0 + ROUNDED) * rated:
        source = "assumed" if evidence.robot.assumed("rated_payload") else "published"
        yield error(
            f"a mass of {evidence.mass:.4g} kg exceeds the arm's rated payload of {rated:g} kg ({source}): check "
            "the unit of the torques, the drive gains and the robot's description",
            "mass",
        )
    findings: dict[str, Finding] = {}
    for payload in evidence.constrained:
        data = "the torques" if evidence.weighed is not None else f"the data of method {payload.method}"
        for test in (active for active in payload.tested if active.conflict):
            text = f"{data} contradict a constraint: {test.description} (p {test.p_value:.1g})"
            findings.setdefault(test.description, error(text))
        for scale in (weighing for weighing in payload.result.weighings if weighing.conflict):
            text = (
                f"{data} show {scale.identified:.4g} ± {scale.identified_sigma:.2g} kg but the scale shows "
                f"{scale.mass:g} ± {scale.sigma:g} kg, {abs(scale.z):.1f} sigma apart: check the drive gains, the "
                "scale, and what else hung on the flange"
            )
            findings.setdefault(f"weighed {scale.mass}", error(text, "mass"))
    together = [payload.result.p_value for payload in evidence.constrained if payload.conflict]
    if together and not findings:
        findings[""] = error(f"the constraints together contradict the data (p {min(together):.1g})")
    # That the body must exist is no bound that someone set.
    chosen = evidence.recommended or next(iter(evidence.constrained), None)
    for test in chosen.tested if chosen is not None else ():
        if not isinstance(test.constraint, PossibleBody):
            text = f"the answer lies on a bound that you gave: {test.description}; check its unit and frame"
            findings.setdefault(test.description, warning(text))
    yield from findings.values()
