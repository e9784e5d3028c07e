"""Errors of drive gains and how far they carry: the torque of motor j is 1 + e_j times its nominal one, always.

No residual shows such an error: all recordings of one arm share it. It is an uncertainty to be given. Motor j acts
on joint j; where drives are coupled, motor k acts on joints j and k (9).
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, field
from msgspec.structs import force_setattr

from ...common import Array, Document, InputError
from ...common.linear import is_covariance
from ...model import Recording, Robot

USUAL: Mapping[str, float] = {"motor": 0.02, "link": 0.01}
"""Standard deviation of a relative error of gains of which nothing is said: of torques that motors tell, and of
torque sensors behind the gear."""
Fingerprints = Mapping[Literal["unloaded", "loaded"], tuple[str, ...]]
"""Fingerprints of the recordings that drive gains were identified from."""


_Share = Annotated[float, Meta(ge=0.0, lt=1.0)]


class Gains(Document, frozen=True, omit_defaults=True):
    """Drive gains and how sure they are: standard deviations of the relative errors e_j of the motors' torques.

    Attributes:
        per_joint: of the own error of each joint's motor (0.02 for 2 %); one number stands for all joints.
        common: of an error that all joints share, as from one current sensor or supply.
        identified: covariance of gains that were identified, n x n, which comes on top; empty where they were not.
        recordings: fingerprints of those they were identified from, without ("unloaded") and with payload
            ("loaded"); empty where they were not read from a log.
        mass: of the payload with which those were [kg]; None where it is not known.
        notes: what else a reader must know of them, one line each.
        assumed: whether nothing is said of them, so that the usual errors are taken.
    """

    per_joint: Sequence[_Share] = field(default_factory=lambda: (0.0,))
    common: _Share = field(default_factory=lambda: 0.0)
    identified: Sequence[Sequence[float]] = ()
    recordings: Fingerprints = field(default_factory=dict)
    mass: float | None = None
    notes: tuple[str, ...] = ()
    assumed: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "identified", tuple(tuple(float(v) for v in row) for row in self.identified))
        force_setattr(self, "per_joint", tuple(float(sigma) for sigma in self.per_joint))
        if not any(self.recordings.values()):
            force_setattr(self, "recordings", {})
            force_setattr(self, "mass", None)
        sigmas = (*self.per_joint, self.common)
        if not self.per_joint or not all(0.0 <= sigma < 1.0 for sigma in sigmas):
            values = ", ".join(f"{sigma:g}" for sigma in sigmas)
            raise InputError(f"relative errors of drive gains {values}: give standard deviations from 0 to below 1")
        square = all(len(row) == len(self.identified) for row in self.identified)
        if self.identified and not (square and is_covariance(np.array(self.identified))):
            raise InputError("the identified gains' matrix is no covariance: identify them again")

    def covariance(self, n: int) -> Array:
        """Covariance of e_1 .. e_n, n x n.

        Raises:
            InputError: if there are neither one nor n numbers.
        """
        if len(self.per_joint) not in (1, n):
            raise InputError(f"{len(self.per_joint)} uncertainties of drive gains for {n} joints: give 1 or {n}")
        own = np.broadcast_to(self.per_joint, (n,))
        known = np.array(self.identified) if self.identified else np.zeros((n, n))
        if known.shape != (n, n):
            raise InputError(f"a covariance of {len(known)} drive gains for {n} joints: identify gains of this arm")
        return np.asarray(np.diag(np.square(own)) + self.common**2 + known)

    def says_as(self, other: "Gains", n: int) -> bool:
        """True if both are one uncertainty of n gains, however it is written."""
        return np.allclose(self.covariance(n), other.covariance(n), rtol=1e-9, atol=0.0)

    def reused(self, loaded: Sequence[Recording], unloaded: Sequence[Recording]) -> tuple[str, ...]:
        """Note recordings that the gains were identified from and that are used again, one line each.

        Args:
            loaded: with the payload that is asked for.
            unloaded: without, or the robot's own.
        """
        with_load = self.recordings.get("loaded", ())
        again = [recording.source for recording in loaded if recording.fingerprint in with_load]
        if again:
            mass = f", {self.mass:g} kg as given then" if self.mass is not None else ""
            return (
                f"These gains come from this same pair ({', '.join(dict.fromkeys(again))}{mass}): the mass is "
                "what was typed in, it confirms nothing. The intervals take the gains' errors and the recordings' "
                "for unrelated, which they are not. Record another payload.",
            )
        every = (*self.recordings.get("unloaded", ()), *with_load)
        shared = [recording.source for recording in (*unloaded, *loaded) if recording.fingerprint in every]
        if not shared:
            return ()
        named = ", ".join(dict.fromkeys(shared))
        return (
            f"{named}: the gains were identified from it too; the intervals take its noise for unrelated to the "
            "gains' errors.",
        )


def usual_gains(robot: Robot, recordings: Sequence[Recording]) -> Gains | None:
    """Errors of gains of which a user says nothing: what recordings say, else 2 % a motor and 1 % a torque sensor.

    None where all recordings say that their torques are exact.
    """
    usual = USUAL["motor" if any(recording.gains for recording in recordings) else robot.drives.side]
    stated = [recording.gain_sigma for recording in recordings]
    known = max((sigma for sigma in stated if sigma is not None), default=0.0)
    assumed = known < usual and (None in stated or not stated)
    sigma = usual if assumed else known
    return Gains((sigma,), assumed=assumed) if sigma else None


def fingerprints(unloaded: Sequence[Recording], loaded: Sequence[Recording]) -> Fingerprints:
    """Fingerprints of recordings without and with the known payload."""
    without, with_load = (tuple(r.fingerprint for r in group if r.fingerprint) for group in (unloaded, loaded))
    return {"unloaded": without, "loaded": with_load}
