"""The equations of one recording of a payload, constant torques and Coulomb friction taken out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...common.arrays import Array
from ...common.linear import rank, without
from ...model import BaseParameters, Robot
from ...model.regressors import payload_columns
from ...model.visibility import friction_columns
from ..equations.names import PAYLOAD
from ..equations.observation import Observation, Observer
from ..equations.problem import ReducedProblem, merged
from ..equations.shared_torque import SharedTorque, beside, compressed, refilled
from .ripple import Wave

_FREE = "free "
"""Before the names of what is estimated anew in each recording, beside the payload."""
_HELD = "held "
"""Before the names of what constant torques are held at."""


@dataclass(frozen=True, eq=False)
class HeldOffsets:
    """Equations that hold the joints' constant torques near zero.

    Attributes:
        sigma: standard deviation of what they may be [N·m or N], shape (n,); 0 where they are free.
        stiffness: weights of the equations, in units of the rows, shape (n,); 0 where there is none.
    """

    sigma: Array
    stiffness: Array

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Positions of the joints held, from 0."""
        return tuple(int(j) for j in np.flatnonzero(self.stiffness > 0.0))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the constant torques as the equations say them to be; 0 unless asked what if."""
        return tuple(f"{_HELD}OFF{j + 1}" for j in self.joints)

    @property
    def covariance(self) -> Array:
        """Of these."""
        return np.diag(self.sigma[list(self.joints)] ** 2)


def free_offsets(n: int) -> HeldOffsets:
    """No equations: constant torques are wholly free."""
    return HeldOffsets(np.zeros(n), np.zeros(n))


@dataclass(frozen=True, eq=False)
class Run:
    """One recording with payload, cut into blocks of time.

    Attributes:
        source: of the recording with payload.
        blocks: equations in the robot's base parameters (none where the unloaded torque was subtracted), what is
            free in this recording, and ``PAYLOAD``.
        held: equations that hold constant torques near zero.
        ripple: waves that are estimated beside the payload.
    """

    source: str
    blocks: tuple[ReducedProblem, ...]
    held: HeldOffsets
    ripple: tuple[Wave, ...] = ()

    @cached_property
    def problem(self) -> ReducedProblem:
        """The equations of the whole recording without what is free in it."""
        return friction_free(merged(self.blocks), self.held)

    @cached_property
    def frictional(self) -> ReducedProblem:
        """The same with friction as it was: only the robot and the payload are told apart."""
        whole = merged(self.blocks)
        return whole.select([name for name in whole.columns if not name.startswith(_FREE)])

    def without_block(self, k: int) -> ReducedProblem:
        """As ``problem``, of all blocks but one."""
        others = [block for i, block in enumerate(self.blocks) if i != k]
        return friction_free(merged(others), self.held)


def run_observer(robot: Robot, base: BaseParameters | None) -> Observer:
    """Observer of [W, free columns, W_L]; without base parameters for torque differences."""
    free = robot.with_offsets(True)
    own = base.columns if base is not None else ()
    friction = friction_columns(robot)
    columns = (*own, *friction, *payload_columns(free))
    return Observer(free, columns, (*own, *(f"{_FREE}{name}" for name in friction), *PAYLOAD))


def with_columns(recording: Observation, more: Sequence[Array]) -> Observation:
    """The equations with columns of each joint, r_j x k, that are free in this recording."""
    names = tuple(f"{_FREE}{k}" for k in range(more[0].shape[1]))
    W = tuple(np.column_stack([own, wide]) for own, wide in zip(recording.W, more, strict=True))
    return replace(recording, columns=(*recording.columns, *names), W=W)


def friction_free(problem: ReducedProblem, held: HeldOffsets) -> ReducedProblem:
    """The equations less all that constant torques and Coulomb friction can explain, joint by joint.

    Each joint has friction parameters of its own, so that this is exact: what is left are the equations of the
    same least-squares problem after those unknowns were solved for.

    Args:
        problem: with free columns.
        held: one more equation for some joints, "its constant torque is h"; the columns of h stand behind the
            others and are left out where h = 0 is meant.
    """
    free = [k for k, name in enumerate(problem.columns) if name.startswith(_FREE)]
    rest = [k for k in range(len(problem.columns)) if k not in free]
    factors, taken, shared = [], [], list[SharedTorque]()
    for j, factor in enumerate(problem.factors):
        others = beside(problem.shared, j, len(factor))
        kept, off = np.column_stack([factor[:, [*rest, -1]], others]), factor[:, free]
        kept = np.insert(kept, [len(rest)] * len(held.joints), 0.0, axis=1)
        if j in held.joints:
            own, one = np.zeros((1, kept.shape[1])), np.zeros((1, len(free)))
            own[0, len(rest) + held.joints.index(j)] = -held.stiffness[j]
            one[0, free.index(problem.columns.index(f"{_FREE}OFF{j + 1}"))] = held.stiffness[j]
            kept, off = np.vstack([kept, own]), np.vstack([off, one])
        left, others = compressed(without(kept, off), others.shape[1])
        factors.append(left)
        shared += refilled(problem.shared, j, others)
        taken.append(rank(factor[:, free]))
    pairs = list(zip(problem.rows, problem.effective_rows, taken, strict=True))
    return ReducedProblem(
        (*(problem.columns[k] for k in rest), *held.columns),
        tuple(factors),
        tuple(max(rows - r, 0) for rows, _, r in pairs),
        tuple(max(rows - r, 0.0) for _, rows, r in pairs),
        tuple(shared),
    )


def observed_friction_free(recording: Observation) -> Observation:
    """The same for equations held whole; rows keep their times."""
    free = [k for k, name in enumerate(recording.columns) if name.startswith(_FREE)]
    rest = [k for k in range(len(recording.columns)) if k not in free]
    W, Y = [], []
    for A, y in zip(recording.W, recording.Y, strict=True):
        left = without(np.column_stack([A[:, rest], y]), A[:, free]) if len(y) else np.zeros((0, len(rest) + 1))
        W.append(left[:, :-1])
        Y.append(left[:, -1])
    columns: Sequence[str] = tuple(recording.columns[k] for k in rest)
    return Observation(tuple(columns), tuple(W), tuple(Y), recording.t, recording.bandwidth)
