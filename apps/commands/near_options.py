"""Options of ``dynident near``, and the files that it writes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ... import model, trajectories
from ...common.arrays import Array
from ...common.errors import InputError
from ...common.files import write_text
from .. import export, report
from .options import MotionFiles, Options, option
from .values import gains_list, joint_list, positive, positive_number, whole

_DURATION, _RANGE, _MASS = 30.0, 30.0, 3.0  # s, deg, kg


@dataclass(frozen=True)
class NearOptions(Options):
    """Where the robot stands, which joints move how far and how long, and what is known of the payload."""

    GROUP = "motion"

    pose: tuple[float, ...] = option(
        type=gains_list,
        required=True,
        metavar="Q1,Q2,..",
        help="where it stands [deg or m]; =-90,.. with minus",
    )
    second_pose: str | None = option(
        metavar="auto|Q1,Q2,..",
        help="do it again at another wrist pose, outside the range: one that helps, or this one",
    )
    joints: tuple[int, ...] = option(
        type=joint_list, required=True, metavar="J1,J2,..", help="joints that move, such as 2,3,5,6"
    )
    range: tuple[float, ...] | None = option(
        type=gains_list, metavar="R|R1,R2,..", help=f"to either side [deg or m] (default: {_RANGE:g})"
    )
    duration: float = option(type=positive_number, default=_DURATION, metavar="S", help=f"default: {_DURATION:g}")
    mass: float | None = option(group="payload", type=positive_number, metavar="KG", help="the payload was weighed")
    mass_sigma: float | None = option(
        group="payload", type=positive_number, metavar="KG", help="standard deviation of the scale"
    )
    expected_mass: float | None = option(
        group="payload",
        type=positive_number,
        metavar="KG",
        help=f"about its mass, not weighed (default: {_MASS:g})",
    )
    ladder: bool = option(
        group="payload",
        action="store_true",
        help="a motion for 1.25 times the mass expected, and slower runs before it that bound the payload",
    )
    seed: int = option(group="search", type=whole, default=0, help="of the random starts (default: 0)")
    starts: int = option(group="search", type=positive, default=1, metavar="K", help="random starts (default: 1)")

    def check(self, robot: model.Robot) -> None:
        """Refuse what does not go together."""
        if (self.mass is None) != (self.mass_sigma is None):
            raise InputError("--mass and --mass-sigma belong together: a scale errs too, by how much must be said")
        if self.mass is not None:
            self.refuse("expected_mass", "is for a payload that was not weighed: leave it out with --mass")
        if max(self.joints) > robot.n:
            raise InputError(
                f"--joints {max(self.joints)}: robot {robot.name!r} has {robot.n} joints: number them "
                f"from 1, at the base, to {robot.n}"
            )

    def bounded_by(self, payload: model.InertialParameters | trajectories.PayloadSet | None) -> NearOptions:
        """What is expected, no heavier than every payload within bounds.

        Raises:
            InputError: if what is expected is heavier.
        """
        if not isinstance(payload, trajectories.PayloadSet) or self.expected.mass <= payload.mass:
            return self
        if self.mass is None and self.expected_mass is None and not self.ladder:
            return replace(self, expected_mass=payload.mass)
        name = "--mass" if self.mass is not None else "--expected-mass"
        raise InputError(
            f"{self.expected.mass:g} kg are expected and --heaviest-payload allows {payload.mass:g}: give another "
            f"{name}, or a heavier payload"
        )

    def ranges(self, robot: model.Robot) -> Array:
        """A range for each moving joint [rad or m]."""
        numbers, joints = self.range or (_RANGE,), self.joints
        if len(numbers) not in (1, len(joints)):
            raise InputError(
                f"--range has {len(numbers)} numbers for {len(joints)} joints: give one, or one for each"
            )
        turning = [robot.joints[joint - 1].revolute for joint in joints]
        if len(numbers) == 1 and not all(turning):
            raise InputError(
                "--range: give one number for each joint, in deg where it turns and in m where it slides"
            )
        each = numbers * len(joints) if len(numbers) == 1 else numbers
        return np.array([np.radians(x) if turns else x for x, turns in zip(each, turning, strict=True)])

    @property
    def expected(self) -> model.InertialParameters:
        """About what the payload is."""
        mass = self.mass or self.expected_mass or _MASS
        return model.InertialParameters.from_com(mass, [0.0, 0.0, 0.1], 0.003 * mass * np.eye(3))


@dataclass(frozen=True)
class NearFiles(MotionFiles):
    """Formats of the motion, and the file of its rehearsal."""

    rehearsal: str | None = option(
        writes="file",
        metavar="F.csv",
        help="the same way once at a tenth of the speed; F_1.csv, .. with --ladder (default: beside --samples)",
    )

    def written(
        self, result: report.NearResult, problem: trajectories.DesignProblem, bounds: trajectories.JointBounds
    ) -> export.motions.WrittenMotion:
        """The motion as its files hold it, refused where their controllers would break a limit."""
        written = export.motions.WrittenMotion(result.robot, result.motion, bounds, report.near_head(result, 1.0))
        self.check_replays(problem, written)
        return written

    def write_all(self, result: report.NearResult, written: export.motions.WrittenMotion) -> None:
        """Write the motion, its rehearsal and the JSON."""
        self.write(written)
        path = self.rehearsal
        if path is None and self.samples:
            beside = Path(self.samples)
            path = str(beside.with_name(f"{beside.stem}_rehearsal{beside.suffix}"))
        for name, speed in _runs_before(path, result.ladder) if path else ():
            slow = replace(written, plan=result.motion.slowed(speed), head=report.near_head(result, speed))
            write_text(name, export.motions.csv_text(slow, self.rate))
        if self.json:
            report.documents.write_json(self.json, report.documents.near_document(result))


def _runs_before(path: str, ladder: tuple[trajectories.Rung, ...]) -> list[tuple[str, float]]:
    """File and speed of each run before the one at full speed."""
    if not ladder:
        return [(path, trajectories.REHEARSAL)]
    first = Path(path)
    speeds = [rung.speed for rung in ladder if rung.speed < 1.0]
    return [(str(first.with_name(f"{first.stem}_{k}{first.suffix}")), speed) for k, speed in enumerate(speeds, 1)]
