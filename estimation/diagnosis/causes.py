"""The table of other readings: another robot, joints turned or exchanged, units, clocks, gravity.

A reading takes the recordings, or some of them, in another way and is compared with them as described by Vuong's
statistic (Likelihood ratio tests for model selection and non-nested hypotheses, 1989): the mean over blocks of time
of the difference of log-likelihoods, over its standard error. What fits better is suggested, never corrected.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, permutations, product

import numpy as np

from ...common import Mask
from ...model import Coupling, Robot, load_robot, robot_names
from .engine import States, System
from .evidence import Alternative, Evidence, Finding, Severity, note
from .hypotheses import HELPFUL, pull_of

ROBOT, ROBOT_Z = 0.01, 3.0
"""Fraction by which chi2 falls with another robot, and Vuong's statistic, above which it is that robot's."""
TURNED, TURNED_Z = 0.03, 2.5
"""Fraction by which chi2 falls with a joint counted the other way, and Vuong's statistic, above which it is so."""
WEIGHTLESS = 0.36  # fraction by which chi2 falls without gravity, above which the torque holds none
ALIKE = 0.02  # fraction of chi2 within which two robots, or two joints turned round, are the same to the data
BESIDE_PULL = 0.5
"""Fraction of what a pull at the flange takes off above which another robot, or a turned joint, is named besides:
of a real pull others take off .06 at most, of another robot's recordings a pull takes off as much as that robot."""
CONVINCING, CAUSE_Z = 0.2, 3.0
"""Fall of chi2 by a cause where nothing else speaks against the recordings, ``HELPFUL`` where something does;
Vuong's statistic."""
SERIOUS = 0.5  # fall of chi2 above which the assumption was wrong; below, it may have been
AS_GOOD = 1.1  # causes that leave within this factor of the best's chi2 count as equal
SETTLED = 0.1  # fraction of chi2 left below which no less likely causes are tried
SUSPICIOUS = 0.1  # relative residual of some joint above which causes are tried, even if all else looks well
_REPORTED = 3
_ENOUGH = 1200  # states in which causes are searched
_COARSER, _PLENTY = 5, 180  # times fewer states decide first, as long as the second of them are left
_FAR = -0.1  # fall of chi2 by coarser states: such a reading is not compared closer
_LONGEST, _STEP = 50, 0.01  # steps [s] of delays that are tried, to either side
_CLOCKS = 0.2  # s: longest delay at the begin and end of recordings that is tried
_LEAST = 0.02  # a factor beyond this, or beyond its inverse, is no unit but a channel without content
_STUCK = 0.5  # s: a position that is the very same number for longer
_UNIT, _OFF = 0.3, 0.15  # logarithm of a factor that counts as another unit, and as another gain

Read = tuple[str, States, Robot | None]
"""Reading of the recordings: what is assumed, and the states that it makes, of another robot or the same."""


class Comparison:
    """Compares readings with the recordings as described, ``fit``: by every fifth state first."""

    def __init__(self, robot: Robot, states: States, free_gains: bool = False) -> None:
        """Fit the recordings as described, with ``free_gains`` each joint's torque on a scale of its own.

        Gains identified with the robot as described favour it; not of coupled drives, nor with a spring.
        """
        self.robot, self.states = robot, states
        self.free_gains = free_gains and robot.coupling is None and robot.spring is None
        self._few = slice(None, None, max(1, min(_COARSER, len(states.t) // _PLENTY)))
        systems = [System.of(robot, part) for part in (states.taken(self._few), states)]
        self._fits = [system.fit(system.weights, self.free_gains) for system in systems]
        self.fit = self._fits[1]

    def compared(self, reading: Read, worth: float = _FAR, kind: str = "") -> Alternative | None:
        """Compare a reading; None where a few of the states show a fall below ``worth``, or nothing."""
        (name, states, robot), found = reading, None
        for fit, part in zip(self._fits, (states.taken(self._few), states), strict=True):
            system = fit.system
            same = robot is None and np.array_equal(part.q, system.states.q)
            same = same and np.array_equal(part.keep, system.states.keep)
            if same:  # the columns are there
                changed = fit.of_torque(part.torque.T + system.torque - system.states.torque.T)
                changed = changed.system.fit(fit.weights, True) if self.free_gains else changed
            else:
                changed = System.of(robot or self.robot, part).fit(fit.weights, self.free_gains)
            both = system.keep & changed.system.keep
            rise = np.bincount(part.block, np.sum((changed.likelihood - fit.likelihood) * both, axis=0))
            error = float(np.std(rise, ddof=1)) / np.sqrt(len(rise))
            # By log-likelihoods of -1/2 log(variance) a row: the fraction by which chi2 falls.
            fall = 1.0 - float(np.exp(-2.0 * rise.sum() / max(int(both.sum()), 1)))
            found = Alternative(kind, name, fall, float(rise.mean()) / max(error, 1e-300))
            if fall < worth or not both.any():
                return None
        return found


def alternatives(robot: Robot, states: States | None, free_gains: bool = False) -> tuple[Alternative, ...]:
    """Compare what is always compared: joints turned, no gravity, robots of other geometry, and more friction.

    None where there is too little motion; other arguments as of ``Comparison``.
    """
    if states is None:
        return ()
    own = Comparison(robot, states, free_gains)
    speed = own.states.qd.T
    rubs = np.eye(robot.n)[:, :, None] * (np.sign(speed) * np.sqrt(np.abs(speed)))[:, None]
    friction = own.fit.system.with_columns(rubs).effect(range(robot.n)).fall
    gravity, turns = robot.gravity, 1.0 - 2.0 * np.eye(robot.n)
    turned = ((str(j), states.read(np.diag(signs)), None) for j, signs in enumerate(turns, 1))
    found = [own.compared(reading, kind="turned") for reading in turned]
    if any(gravity):
        found.append(own.compared(("", states, replace(robot, gravity=(0.0, 0.0, 0.0))), kind="weightless"))
    for name, other in ((name, load_robot(name)) for name in robot_names()):
        chains = [[(one.kind, one.alpha, one.d, one.theta, one.r) for one in arm.joints] for arm in (robot, other)]
        if other.n == robot.n and chains[0] != chains[1]:
            coupling = other.drives.coupling if robot.drives.fit_for_coupling else None
            drives = replace(robot.drives, coupling=coupling, spring=other.drives.spring)
            other = replace(other, gravity=gravity, drives=drives)
            found.append(own.compared((name, states, other), kind="robot"))
    return (Alternative("friction", "", friction, 0.0), *filter(None, found))


def other_readings(evidence: Evidence) -> list[Finding]:
    """Another shipped robot, a joint counted the other way, or no gravity explain the recordings better.

    A robot takes {ROBOT:.0%} (and z > {ROBOT_Z:g}) off the squared residuals, and more than one further friction
    column a joint does on the robot as described; a turned joint {TURNED:.0%} (z > {TURNED_Z:g}), no gravity
    {WEIGHTLESS:.0%}: do not use. Within {ALIKE:.0%} a note says that the data do not tell two robots apart.
    """
    found, pull = sorted(evidence.alternatives, key=lambda a: -a.fall), pull_of(evidence)
    least = BESIDE_PULL * pull.fall if pull is not None else 0.0
    friction = max((a.fall for a in found if a.kind == "friction"), default=0.0)
    limits = {"weightless": WEIGHTLESS, "robot": max(ROBOT, friction), "turned": TURNED}
    weightless, robots, turned = (
        [a for a in found if a.kind == kind and a.fall > max(fall, least) and a.z > z]
        for (kind, fall), z in zip(limits.items(), (TURNED_Z, ROBOT_Z, TURNED_Z), strict=True)
    )
    findings = [_cause("the torques lack gravity (already compensated)", best) for best in weightless]
    findings += [_cause(f"the robot is {best.name!r}", best) for best in robots[:1]]
    for best in turned[:1]:
        names = " or ".join(a.name for a in turned if a.fall > best.fall - ALIKE)
        findings.append(_cause(f"joint {names} has the opposite sign, in position and torque", best))
    alike = " or ".join(repr(a.name) for a in found if a.kind == "robot" and a.fall > -ALIKE)
    if alike and pull is None and not robots:
        as_well = f"{alike} would fit these data as well as {evidence.robot.name!r}"
        findings.append(note(f"{as_well}: make sure the robot is right"))
    return findings


def _cause(assumption: str, found: Alternative, source: str = "") -> Finding:
    looks = f"{source} looks" if source else "the recordings look"
    text = (
        f"{looks} as if {assumption}: with that correction the squared residuals fall by {100 * found.fall:.0f} % "
        f"({found.z:.1f} standard errors)"
    )
    severity: Severity = "warning" if source and found.fall < SERIOUS else "error"
    return Finding(severity, source or "everything", text, True, found.fall)


def likely_causes(
    robot: Robot, states: States | None, contradicted: bool = True, free_gains: bool = False
) -> list[Finding]:
    """Name what would explain the recordings better: all of them, those of one kind, or the worst of a kind.

    ``contradicted``: whether something is known to be wrong; if not, only a clear gain counts; ``free_gains`` as of
    ``Comparison``.
    """
    if states is None:
        return []
    states = states.taken(slice(None, None, max(1, len(states.t) // _ENOUGH)))
    described = Comparison(robot, states, free_gains)
    least = HELPFUL if contradicted else CONVINCING
    squares = described.fit.weights**2 @ described.fit.errors**2
    means = np.bincount(states.recording, squares) / np.maximum(np.bincount(states.recording), 1)
    masks = [np.ones(len(states.t), dtype=bool), states.loaded == 0.0, states.loaded > 0.0]
    for numbers in (np.unique(states.recording[kind]) for kind in masks[1:]):
        masks += [states.recording == number for number in numbers[np.argsort(-means[numbers])[:1]]]
    distinct = {mask.tobytes(): mask for mask in masks if mask.any()}.values()
    names = [recording.source for recording in states.recordings]
    parts = [", ".join(names[k] for k in np.unique(states.recording[mask])) * (not mask.all()) for mask in distinct]
    tried: list[tuple[Alternative, str]] = []
    for family, several in FAMILIES:
        for source, mask in zip(parts, distinct, strict=True):
            readings = ((name, states.mixed(read, mask), other) for name, read, other in family(described, mask))
            compared = (described.compared(reading, 0.5 * least) for reading in readings)
            own = [found for found in compared if found is not None and found.fall > least and found.z > CAUSE_Z]
            own.sort(key=lambda found: -found.fall)
            tried += [(found, source) for found in (own if several else own[:1])]
        if any(1.0 - found.fall < SETTLED for found, _ in tried):
            break
    if not tried:
        return []
    left = AS_GOOD * (1.0 - max(found.fall for found, _ in tried))
    alike = [(found, source) for found, source in tried if 1.0 - found.fall <= left]
    best, where = alike[0]
    named = dict.fromkeys(found.name for found, source in alike if source == where)
    return [_cause(", or ".join(list(named)[:_REPORTED]), best, where)]


def delays(own: Comparison, _: Mask) -> Iterator[Read]:
    """Torque written later or earlier than position."""
    for delay in (_STEP * step for step in range(-_LONGEST, _LONGEST + 1) if step):
        late = "lags" if delay > 0.0 else "leads"
        yield f"torque {late} position by about {abs(delay):.2f} s", own.states.later(delay), None


def clocks(own: Comparison, _: Mask) -> Iterator[Read]:
    """Torque and position on two clocks: a delay that grows from the begin to the end of a recording."""
    for first, last in permutations(np.linspace(-_CLOCKS, _CLOCKS, 9).tolist(), 2):
        text = f"torque lags by {first:.2f} s at the start and {last:.2f} s at the end"
        changed = own.states.later(first + (last - first) * own.states.passed)
        yield f"torque and position ran on two clocks ({text})", changed, None


def joint_columns(own: Comparison, _: Mask) -> Iterator[Read]:
    """Joints, torques or positions exchanged, of the wrong sign, or with a zero a quarter or half turn away."""
    n, states, one = own.robot.n, own.states, np.eye(own.robot.n)
    for j, signs in enumerate(1.0 - 2.0 * one, 1):
        yield f"the sign of the torque of joint {j} is wrong", states._replace(torque=states.torque * signs), None
    for i, j in combinations(range(n), 2):
        names, order = f"joints {i + 1} and {j + 1} are exchanged", np.arange(n)
        order[[i, j]] = j, i
        changed = states.read(one[order])
        yield f"the torques of {names}", states._replace(torque=changed.torque), None
        yield names, changed, None
        yield f"the positions of {names}", changed._replace(torque=states.torque), None
    for j, signs in enumerate(1.0 - 2.0 * one, 1):
        changed = states.read(np.diag(signs))
        yield f"the sign of q{j} is wrong", changed._replace(torque=states.torque), None
        yield f"joint {j} has the opposite sign, in position and torque", changed, None
    for j, quarters in product(range(1, n), (1, 3, 2)):
        text = f"the zero of q{j + 1} is off by {180 if quarters == 2 else 90} degrees"
        yield text, states._replace(q=states.q + quarters * np.pi / 2 * one[j]), None


def gravity(own: Comparison, mask: Mask) -> Iterator[Read]:
    """Gravity along another axis."""
    usual = np.array(own.robot.gravity)
    size = float(np.linalg.norm(usual)) or 9.81
    mounted = {"gravity points the other way (the robot is mounted upside down)": -usual}
    for axis, sign in product(np.flatnonzero(np.abs(usual) <= 0.9 * size), (1.0, -1.0)):
        along = f"{'-' * (sign < 0)}{'xyz'[axis]} of frame 0 (the robot is mounted on a wall)"
        mounted[f"gravity points along {along}"] = sign * size * np.eye(3)[axis]
    for text, other in mounted.items() if mask.all() else ():
        yield text, own.states, replace(own.robot, gravity=tuple(other.tolist()))


def descriptions(own: Comparison, mask: Mask) -> Iterator[Read]:
    """Drives coupled that are described as single, and lengths a tenth off."""
    robot, drives, states = own.robot, own.robot.drives, own.states
    if not mask.all():
        return
    if robot.coupling is None and robot.n > 1 and drives.fit_for_coupling:
        coupled = Coupling((robot.n - 1, robot.n))
        text = f"the drives of joints {robot.n - 1} and {robot.n} are coupled, which the description does not say"
        yield text, states, replace(robot, drives=replace(drives, coupling=coupled))
    for (j, joint), name in product(enumerate(robot.joints), ("d", "r")):
        length = getattr(joint, name)
        for factor, word in ((0.9, "shorter"), (1.1, "longer")) if length != 0.0 else ():
            joints = (*robot.joints[:j], replace(joint, **{name: factor * length}), *robot.joints[j + 1 :])
            text = f"the length {name}{j + 1} is {word} than the {length:g} m in the description"
            yield text, states, replace(robot, joints=joints)


def offsets(own: Comparison, mask: Mask) -> Iterator[Read]:
    """A torque channel with an offset, constant or growing with time."""
    n, passed, square = own.robot.n, own.states.passed, own.fit.weights**2
    for (shape, text), j in product(((passed**0, "holds an offset of"), (passed, "drifts by")), range(n)):
        column = np.zeros((n, len(passed)))
        column[j] = shape * mask
        left = own.fit.of_torque(column).errors
        shown = float(square @ (left**2).sum(axis=1))
        if shown > 1e-9 * square[j] * float(np.sum(column**2)):
            size = float(square @ (left * own.fit.errors).sum(axis=1)) / shown
            assumed = f"the torque of joint {j + 1} {text} {size:.3g} (N·m or N)"
            yield assumed, own.states._replace(torque=own.states.torque - size * column.T), None


def channels(own: Comparison, mask: Mask) -> Iterator[Read]:
    """Torque channels with a wrong drive gain, a reversed list of gains, or no common unit."""
    states, n, norms = own.states, own.robot.n, own.fit.system.norms
    if own.free_gains:
        return
    each = np.eye(n)[:, :, None] * (states.torque * mask[:, None]).T
    left = np.array([own.fit.of_torque(torque).errors / norms[:, None] for torque in each])
    gram = np.einsum("ijn,kjn->ik", left, left)
    shown = np.einsum("ijn,jn->i", left, own.fit.errors / norms[:, None]) / np.maximum(np.diag(gram), 1e-300)
    for j, ratio in enumerate((1.0 - shown).tolist()):
        if _LEAST < ratio < 1.0 / _LEAST and abs(np.log(ratio)) >= _OFF:
            size = f"{1.0 / ratio:.2g} times too large" if ratio < 1.0 else f"{ratio:.2g} times too small"
            text = f"the torque of joint {j + 1} is about {size} (drive gain or unit)"
            own_ratio = np.where(np.arange(n) == j, ratio, 1.0)
            yield text, states._replace(torque=states.torque * own_ratio), None
    gains = states.recordings[0].gains
    if gains and gains != gains[::-1]:
        reverse = np.array(gains[::-1]) / np.array(gains)
        yield "the list of drive gains is reversed", states._replace(torque=states.torque * reverse), None
    fixed, factors = int(np.argmax(norms)), np.ones(n)
    free = [j for j in range(n) if j != fixed]
    factors[free] = -np.linalg.lstsq(gram[np.ix_(free, free)], gram[free, fixed], rcond=1e-12)[0]
    usable = mask.all() and (factors > _LEAST).all() and (factors < 1.0 / _LEAST).all()
    if usable and (np.abs(np.log(factors)) > _UNIT).sum() > 1:
        sizes = ", ".join(f"{1.0 / factor:.2g}" for factor in factors)
        text = (
            f"each joint's torque has its own unit (joint by joint {sizes} times too large), such as motor-side "
            "torque or percent of each drive's maximum"
        )
        yield text, states._replace(torque=states.torque * factors), None


def stuck_encoders(own: Comparison, _: Mask) -> Iterator[Read]:
    """An encoder that sticks while the robot moves on."""
    states, stuck = own.states, np.zeros(own.states.q.shape, dtype=bool)
    for number, recording in enumerate(states.recordings):
        there = states.recording == number
        for j, q in enumerate(recording.q.T):
            edges, t = np.flatnonzero(np.diff(q)) + 1, states.t[there]
            starts, stops = recording.t[np.append(0, edges)], recording.t[np.append(edges - 1, -1)]
            place = np.maximum(np.searchsorted(starts, t, "right") - 1, 0)
            stuck[there, j] = (stops - starts > _STUCK)[place] & (t <= stops[place])
    for j, still in enumerate(stuck.T, 1):
        if 0.0 < still.mean() < 0.8:  # a joint that rests for longer does not move
            start, stop = states.t[still][0], states.t[still][-1]
            text = f"the encoder of joint {j} is stuck from {start:.3g} s to {stop:.3g} s"
            yield text, states._replace(keep=states.keep & ~still[:, None]), None


FAMILIES: tuple[tuple[Callable[[Comparison, Mask], Iterator[Read]], bool], ...] = (
    (delays, False),
    (gravity, True),
    (joint_columns, True),
    (clocks, False),
    (offsets, True),
    (channels, True),
    (stuck_encoders, True),
    (descriptions, True),
)
"""Readings, the likelier ones first, and whether several of one family may be named as equally good."""
