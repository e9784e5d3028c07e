"""The equations of one recording of a payload, constant torques and Coulomb friction taken out."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...model import BaseParameters, Robot, friction_columns, payload_columns
from ...model.arrays import Array
from ...model.visibility import without
from ..names import PAYLOAD
from ..observation import Observation, Observer
from ..problem import ReducedProblem, merged, triangular

_FREE = "free "
"""Before the names of what is estimated anew in each recording, beside the payload."""


@dataclass(frozen=True, eq=False)
class Run:
    """One recording with payload, cut into blocks of time.

    Attributes:
        source: of the recording with payload.
        blocks: equations in the robot's base parameters (none where the unloaded torque was subtracted), what is
            free in this recording, and ``PAYLOAD``.
    """

    source: str
    blocks: tuple[ReducedProblem, ...]

    @cached_property
    def problem(self) -> ReducedProblem:
        """The equations of the whole recording without what is free in it."""
        return friction_free(merged(self.blocks))

    @cached_property
    def frictional(self) -> ReducedProblem:
        """The same with friction as it was: only the robot and the payload are told apart."""
        whole = merged(self.blocks)
        return whole.select([name for name in whole.columns if not name.startswith(_FREE)])

    def without_block(self, k: int) -> ReducedProblem:
        """As ``problem``, of all blocks but one."""
        return friction_free(merged([block for i, block in enumerate(self.blocks) if i != k]))


def run_observer(robot: Robot, base: BaseParameters | None) -> Observer:
    """Observer of [W, free columns, W_L]; without base parameters for torque differences."""
    free = robot.with_offsets(True)
    own = base.columns if base is not None else ()
    friction = friction_columns(robot)
    columns = (*own, *friction, *payload_columns(free))
    return Observer(free, columns, (*own, *(f"{_FREE}{name}" for name in friction), *PAYLOAD))


def friction_free(problem: ReducedProblem) -> ReducedProblem:
    """The equations less all that constant torques and Coulomb friction can explain, joint by joint.

    Each joint has friction parameters of its own, so that this is exact: what is left are the equations of the
    same least-squares problem after those unknowns were solved for.
    """
    free = [k for k, name in enumerate(problem.columns) if name.startswith(_FREE)]
    rest = [k for k in range(len(problem.columns)) if k not in free]
    factors, taken = [], []
    for factor in problem.factors:
        own = factor[:, free]
        factors.append(triangular(without(factor[:, [*rest, -1]], own)))
        taken.append(_rank(own))
    pairs = list(zip(problem.rows, problem.effective_rows, taken, strict=True))
    return ReducedProblem(
        tuple(problem.columns[k] for k in rest),
        tuple(factors),
        tuple(max(rows - r, 0) for rows, _, r in pairs),
        tuple(max(rows - r, 0.0) for _, rows, r in pairs),
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


def _rank(columns: Array) -> int:
    size = np.linalg.norm(columns, axis=0)
    used = columns[:, size > 0.0]
    return int(np.linalg.matrix_rank(used / size[size > 0.0], tol=1e-8)) if used.shape[1] else 0
