"""Which joints move in a short motion, and the motion with all others at rest."""

from collections.abc import Sequence

import numpy as np

from ...common.errors import InputError
from ...model import Motion, Processing
from ...model.motion import Measurement
from ..signals.rows import Mask, moving_parts, used_rows

SLOW = 0.03
"""rad/s or m/s: rows of a slower joint are not used; the sign of its friction is not sure there."""
_SHARE = 0.1  # of the moving time: a joint that moves less is held
_AT_REST = 5e-3  # rad or m: a held joint's positions spread no more; a wider one went to another pose


def moving_joints(motions: Sequence[Motion], still_speed: float) -> tuple[int, ...]:
    """Numbers of the joints that move; a joint that only changes its pose between two motions is held.

    Args:
        motions: of one session.
        still_speed: a joint below it stands still [rad/s or m/s].

    Raises:
        InputError: if none moves.
    """
    fast = np.vstack([np.abs(motion.qd[moving_parts(motion, still_speed)]) > SLOW for motion in motions])
    joints = tuple(int(j) + 1 for j in np.flatnonzero(fast.mean(axis=0) > _SHARE)) if len(fast) else ()
    if not joints:
        raise InputError("no joint moves: record the short motion that 'dynident near' gives")
    return joints


def at_rest(data: Measurement, moving: Sequence[int]) -> Measurement:
    """The measurement with held joints exactly at rest: what their encoders flicker is no motion.

    A held joint that goes to another pose on the way keeps what was measured.
    """
    motion = data.motion
    q, qd, qdd = (np.array(x) for x in (motion.q, motion.qd, motion.qdd))
    for j in range(motion.n):
        if j + 1 not in moving and np.ptp(q[:, j]) < _AT_REST:
            q[:, j], qd[:, j], qdd[:, j] = q[:, j].mean(), 0.0, 0.0
    return Measurement(Motion(motion.t, q, qd, qdd), data.torque)


def telling_rows(motion: Motion, moving: Sequence[int], processing: Processing, ends: bool = False) -> Mask:
    """Rows that say something, N x n: of a moving joint, fast enough that its friction's sign is known.

    Args:
        motion: the motion.
        moving: numbers of the joints that move.
        processing: settings.
        ends: keep also the ends at which a recording was cut in full motion, which ``used_rows`` leaves out.
    """
    speed = np.abs(motion.qd)
    whole = moving_parts(motion, processing.still_speed) if ends else used_rows(motion, processing).moving
    least = np.maximum(processing.slow_fraction * speed[whole].max(axis=0, initial=0.0), SLOW)
    keep: Mask = (speed >= least) & whole[:, None]
    keep[:, [j for j in range(motion.n) if j + 1 not in moving]] = False
    return keep
