"""Open loop and replay: how far predicted motion strays from measured motion, by horizon.

Simulator users accept a model by the motion it predicts over a fraction of a second from the measured torques, on a
recording that was never fitted. Small residuals do not prove that: a rotor inertia at zero leaves the torques right
and the motion wrong. Open loop alone does not prove the contrary either: where errors of the start grow fast, no
model could do better, and the replay under a controller decides.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...common.arrays import Array
from ...common.errors import InputError
from ...common.progress import Progress, each
from ...estimation.fit.settings import DEFAULTS, Settings
from ...estimation.results.parts import Horizon, Rollout
from ...estimation.signals.filtering import lowpass, measurement, slopes
from ...estimation.signals.rows import least_speed
from ...model import Processing, Recording, Robot, base_parameters
from ...model.motion import Measurement
from .arm import IdentifiedArm, Predict

HORIZONS = (0.1, 0.5, 1.0, 2.0)
"""s: after which times the error is stated, unless others are asked for."""
IDENTIFIED, CONSTANT = "identified", "constant speed"
_STARTS = 200  # at most
_APART = 0.05  # s: between starts, at least
_SETTLING = 3.0  # periods of the cut-off at the ends of a recording that the filter does not get right
_LARGEST_END = 0.05  # of the recording
_CURVE = 40  # points of the drawn curve
_NUDGE = 1e-6
"""rad or m: an error of the start whose growth is looked at."""
GROWTH_TIME = 0.5
"""s: after which the growth of an error of the start is stated."""
_SEGMENT, _LEAD = 2.5, 0.5  # s: of the replay, which is made in pieces, and what its controller takes to settle


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of predicted motion on one recording, from every start."""

    turning: bool  # all joints turn: errors are in rad then, else mixed with m
    times: Array  # after the start [s], shape (K,), the horizons among them
    by: Mapping[str, Array]  # model -> root mean square over the joints of each start at each time, S x K
    resting: NDArray[np.bool_]  # starts at which no joint moved, shape (S,)

    def spread(self, model: str, seconds: float, resting: bool = False) -> tuple[float, float] | None:
        """Error of a model after one of ``times``, median and 90 % of the starts; None without such starts."""
        k = int(np.argmin(np.abs(self.times - seconds)))
        errors = self.by[model][self.resting == resting, k]
        if not len(errors):
            return None
        ordered = np.sort(np.where(np.isfinite(errors), errors, np.inf))
        half, most = (float(ordered[int(share * (len(ordered) - 1))]) for share in (0.5, 0.9))
        return half, most

    def spreads(self, seconds: float, resting: bool) -> dict[str, tuple[float, float]] | None:
        """Errors of every model by its name; None without such starts."""
        every = {model: self.spread(model, seconds, resting) for model in self.by}
        return {model: spread for model, spread in every.items() if spread is not None} or None


def roll_out_all(
    robot: Robot,
    values: Array,
    recordings: Sequence[Recording],
    settings: Settings = DEFAULTS,
    horizons: Sequence[float] = HORIZONS,
    others: Mapping[str, Predict] | None = None,
) -> tuple[Rollout, ...]:
    """Predict each recording's motion from its torques, from many starts, and follow its path.

    Args:
        values: of the columns of ``base_parameters(robot)``.
        recordings: without payload, best such that were not fitted.
        settings: processing and progress.
        horizons: after which times errors are asked for [s]; those beyond half a recording are left out.
        others: models to compare with, by name.
    """
    settings.progress("the robot's equations of motion")
    base = base_parameters(robot)
    if len(values) != len(base.columns):
        raise InputError(
            f"{len(values)} values for {len(base.columns)} base parameters: give the robot as it was identified "
            "(Identification.robot), for its recordings chose its friction"
        )
    arm = IdentifiedArm(robot, base, values)
    models, processing = {IDENTIFIED: arm.positions, **(others or {})}, settings.processing_of(robot)
    return tuple(
        _rolled(arm, recording, processing, horizons, models, settings.progress) for recording in recordings
    )


def _rolled(
    arm: IdentifiedArm,
    recording: Recording,
    processing: Processing,
    horizons: Sequence[float],
    models: Mapping[str, Predict],
    progress: Progress,
) -> Rollout:
    measured = measurement(recording, processing)
    motion, step = measured.motion, float(measured.motion.t[1] - measured.motion.t[0])
    duration = step * (len(motion.t) - 1)
    lengths = [seconds for seconds in sorted(horizons) if seconds <= 0.5 * duration]
    if not lengths:
        raise InputError(
            f"{recording.source}: {duration:.3g} s are too short for a horizon of {min(horizons):g} s: record at "
            "least twice the horizon"
        )
    count = round(lengths[-1] / step) + 1
    curve = np.linspace(0.0, lengths[-1], _CURVE + 1)[1:]
    samples = np.unique(np.clip(np.rint(np.concatenate([curve, lengths]) / step).astype(int), 1, count - 1))
    # Away from the ends, which the filter does not get right.
    size, cutoff = len(motion.t), processing.cutoff
    edge = min(round(_SETTLING / cutoff / step), int(_LARGEST_END * size)) if cutoff else 0
    last = size - count - edge
    number = min(_STARTS, max(1, int((last - edge) * step / _APART)))
    starts = np.linspace(edge, max(last, edge), number).astype(np.intp)
    windows = starts[:, None] + np.arange(count)
    q, qd, torque = motion.q[starts], motion.qd[starts], measured.torque[windows]
    truth = motion.q[windows]
    by = {}
    for name, predict in each(list(models.items()), lambda entry: f"{recording.source}: {entry[0]}", progress):
        by[name] = _rms(predict(q, qd, torque, step) - truth)[:, samples]
    ahead = q[:, None] + qd[:, None] * (step * np.arange(count))[:, None]
    by[CONSTANT] = _rms(ahead - truth)[:, samples]
    resting = np.max(np.abs(qd), axis=1) < processing.still_speed
    progress(f"{recording.source}: growth of errors, replay")
    growth = _growth(arm, q, qd, torque, step)
    relative, joints, strayed = _replay(arm, measured, processing, recording.source)
    errors = Errors(all(joint.revolute for joint in arm.robot.joints), step * samples, by, resting)
    return Rollout(
        source=recording.source,
        starts_in_motion=int((~resting).sum()),
        starts_at_rest=int(resting.sum()),
        diverged=int((~np.isfinite(by[IDENTIFIED][:, -1])).sum()),
        horizons=tuple(Horizon(t, errors.spreads(t, False), errors.spreads(t, True)) for t in lengths),
        growth=growth,
        replay_relative=relative,
        replay_joints=joints,
        replay_strayed=strayed,
    ).made_by(errors)


def _rms(difference: Array) -> Array:
    """Root mean square over the joints, the last axis; inf where a start ran away."""
    with np.errstate(all="ignore"):
        rms = np.sqrt(np.mean(np.square(difference), axis=2))
    return np.where(np.isfinite(rms), rms, np.inf)


def _growth(arm: IdentifiedArm, q: Array, qd: Array, torque: Array, step: float) -> float:
    """Factor by which an error of the start's positions grows; the error's direction is drawn, its seed fixed."""
    count = round(GROWTH_TIME / step) + 1
    if count > torque.shape[1]:
        return float("nan")
    nudge = np.random.default_rng(0).standard_normal(q.shape)
    nudge *= _NUDGE / np.linalg.norm(nudge, axis=1, keepdims=True)
    ends = [arm.positions(start, qd, torque[:, :count], step)[:, -1] for start in (q, q + nudge)]
    with np.errstate(all="ignore"):
        growth = np.linalg.norm(ends[1] - ends[0], axis=1) / _NUDGE
    return float(np.median(np.where(np.isfinite(growth), growth, np.inf)))


def _replay(
    arm: IdentifiedArm, measured: Measurement, processing: Processing, source: str
) -> tuple[float, Array, float]:
    """Follow the path in overlapping pieces, all at once; torques are compared below the cut-off."""
    motion, size = measured.motion, len(measured.motion.t)
    step = float(motion.t[1] - motion.t[0])
    lead = min(round(_LEAD / step), size // 4)
    length = min(round(_SEGMENT / step), size - lead)
    pieces = max(1, (size - lead) // length)
    windows = length * np.arange(pieces)[:, None] + np.arange(lead + length)
    # A stiff controller would feel speeds that are not the slopes of the positions.
    q, torque = arm.followed(motion.q[windows], slopes(motion.q, step)[windows], step)
    joined = slice(lead, lead + pieces * length)
    n = motion.q.shape[1]
    predicted = torque[:, lead:].reshape(-1, n)
    strayed = (q - motion.q[windows])[:, lead:]
    speeds = np.abs(motion.qd)
    fast = speeds[joined] >= least_speed(speeds.max(axis=0), processing)
    measured_q, followed = (
        np.where(fast, lowpass(torques, step, processing.cutoff, source), 0.0)
        for torques in (measured.torque[joined], predicted)
    )
    errors, norms = np.linalg.norm(followed - measured_q, axis=0), np.linalg.norm(measured_q, axis=0)
    with np.errstate(all="ignore"):
        joints = np.where(norms > 0.0, errors / norms, np.nan)
        relative = float(np.linalg.norm(errors) / np.linalg.norm(norms))
    return relative, joints, float(np.sqrt(np.mean(np.square(strayed))))
