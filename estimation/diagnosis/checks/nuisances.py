"""What else is in the torques or positions: a tilted base, a delay, a slip, another zero."""

from collections.abc import Sequence

import numpy as np

from ....common.arrays import Array
from ..evidence import Evidence
from ..finding import Finding, error, note, warning
from ..nuisances import Nuisance
from ..pull import Pull
from ..rivals import mixed_up
from ..states import states_of
from .loaded import MOVED
from .robot import TURNED, TURNED_Z, arm_weight, other_robots, turned_joints

STEEP = np.radians(5.0)
"""rad: a tilt that no mounting has by mistake; nothing should be used."""
LATE, LATE_Z = 0.008, 5.0
"""s and standard deviations of a delay between torque and position."""
SLIP, SLIP_Z = 0.01, 6.0
"""m and standard deviations by which the centre of mass differs in the second half of the loaded recordings."""
_GUARDS = ("residual", "unexplained", "joints", "shares_together", "scale")


def tilted(evidence: Evidence) -> list[Finding]:
    """Gravity that leans from the robot's description; what stands out is taken out of the payload."""
    tilt = evidence.tilt
    if tilt is None or not tilt.stands_out:
        return []
    text = (
        f"gravity leans by {np.degrees(tilt.angle):.1f} ± {np.degrees(tilt.sigma):.1g} degrees from the robot's "
        "description (is the base level?)"
    )
    if tilt.angle > STEEP:
        return [error(f"{text}: correct gravity in the robot's file, or the mounting")]
    left = "the robot's parameters hold that" if evidence.of_robot else "the payload is corrected for it"
    return [note(f"{text}: {left}")]


def pulled(evidence: Evidence) -> list[Finding]:
    """A hose or cable at the flange; against every number where the mass rests on what it does."""
    pull = evidence.pull
    if pull is None:
        return []
    left = ": the robot's parameters hold that" if evidence.of_robot else _less(evidence, pull)
    text = (
        f"{pull.where} something pulls at the flange ({_like(pull)}), a hose or cable?{left}: take it off, or "
        "fasten it so that it does not pull, and record again"
    ).strip()
    if evidence.of_robot:
        return [note(text)]
    return [error(text) if _moves(evidence, pull.change, 2.0 * pull.mass_sigma) else warning(text)]


def _moves(evidence: Evidence, change: Array, more: float = 0.0) -> bool:
    """Whether a change of the ten moves the mass, by so much [kg] more, or the centre of mass."""
    mass = abs(evidence.mass)
    far = float(np.linalg.norm(change[6:9])) > SLIP * mass
    return far or not abs(change[9]) + more <= MOVED * mass


def _like(pull: Pull) -> str:
    (stiffness, *_, up), (sigma, *_, up_sigma) = pull.values, np.sqrt(np.diag(pull.covariance))
    return f"{stiffness:.3g} ± {sigma:.1g} N/m, {pull.sideways:.2g} N to the side, {up:.2g} ± {up_sigma:.1g} N up"


def _less(evidence: Evidence, pull: Pull) -> str:
    mass = evidence.mass + pull.change[9]
    if not np.isfinite(mass) or not np.isfinite(pull.mass_sigma):
        return ""
    return f" without it the mass would be {mass:.3g} ± {pull.mass_sigma:.1g} kg"


def late(evidence: Evidence) -> list[Finding]:
    """Torques that were written later or earlier than positions."""
    return [
        _against(
            evidence,
            nuisance,
            f"{_of(nuisance)} {'lag' if nuisance.size > 0.0 else 'lead'} position by about "
            f"{1e3 * abs(nuisance.size):.0f} ± {1e3 * nuisance.sigma:.1g} ms or more: check the log's time stamps",
        )
        for nuisance in _seen(evidence, "late", LATE, LATE_Z)
    ]


def slipped(evidence: Evidence) -> list[Finding]:
    """A centre of mass that is another one in the second half of the loaded recordings."""
    return [
        error(
            f"the centre of mass moves by {1e3 * nuisance.size:.0f} ± {1e3 * nuisance.sigma:.1g} mm half way "
            "through the recordings with payload: did it slip?",
            "centre of mass",
        )
        for nuisance in _seen(evidence, "slip", SLIP, SLIP_Z)
    ]


def _seen(evidence: Evidence, kind: str, size: float, z: float) -> list[Nuisance]:
    return [
        nuisance
        for nuisance in evidence.nuisances
        if nuisance.kind == kind and abs(nuisance.size) > size and nuisance.z > z
    ]


def _of(nuisance: Nuisance) -> str:
    return f"the torques{nuisance.where}"


def _against(evidence: Evidence, nuisance: Nuisance, text: str) -> Finding:
    """Against all where it moves mass or centre of mass, else the inertia; worth knowing of a robot alone."""
    if evidence.of_robot:
        return note(text)
    if _moves(evidence, nuisance.change):
        return error(f"{text}{_mass(evidence, nuisance)}")
    return warning(text)


def _mass(evidence: Evidence, nuisance: Nuisance) -> str:
    if not np.isfinite(evidence.mass) or not len(nuisance.change):
        return ""
    return f"; corrected for it, the mass is {evidence.mass + nuisance.change[9]:.3g} kg"


def zeros_apart(evidence: Evidence) -> list[Finding]:
    """Positions of a pair that differ by a constant: the encoder's zero was set anew in between."""
    if evidence.sampled is not None:
        return list(evidence.sampled.zeros)
    return [
        error(
            f"q{j + 1} of {pair.loaded.source} differs from that of {pair.unloaded.source} by a constant "
            f"{1e3 * pair.constant[j]:+.1f} mrad or mm: was the encoder's zero set anew in between?"
        )
        for pair in evidence.compared
        for j in pair.new_zeros
    ]


def mixtures(evidence: Evidence, raised: Sequence[str]) -> list[Finding]:
    """Joints or channels that changed places, a reversed gain list, a fault in one recording only.

    Args:
        raised: names of the checks that speak against the recordings.
    """
    if evidence.source is None or not set(raised) & set(_GUARDS):
        return []
    recordings = (*evidence.source.unloaded, *evidence.source.loaded)
    gains = next((recording.gains for recording in recordings if recording.gains), ())
    readings = mixed_up(evidence.robot, states_of(evidence.source), gains)
    readings = tuple(rival for rival in readings if rival.fall > TURNED and rival.z > TURNED_Z)
    if not readings:
        return []
    best = max(readings, key=lambda rival: rival.fall)
    text = (
        f"the recordings look as if {best.name}: corrected for it, the squared residuals fall by "
        f"{100 * best.fall:.0f} % ({best.z:.1f} standard errors)"
    )
    return [Finding("error", "everything", text, cause=True, explains=best.fall)]


OF_ROBOT = (other_robots, turned_joints, arm_weight, tilted, late, pulled)
"""Checks that a robot without payload passes too."""
