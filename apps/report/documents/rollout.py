"""The document of ``rollout``."""

from collections.abc import Sequence

from ....common.schema import Document
from ....estimation.results.parts import HorizonDocument, Number, RolloutDocument
from ...rollout import Rollout


class RolloutsDocument(Document, frozen=True):
    """Open loop and replay on each recording."""

    robot: str
    rollouts: tuple[RolloutDocument, ...]


def rollouts_document(robot: str, rollouts: Sequence[Rollout]) -> RolloutsDocument:
    """Make the document of ``dynident rollout --json``; ``robot``: its name."""
    return RolloutsDocument(robot, tuple(map(rollout_document, rollouts)))


def rollout_document(rollout: Rollout) -> RolloutDocument:
    """Errors by horizon, and the replay."""
    resting, replay = int(rollout.resting.sum()), rollout.replay
    return RolloutDocument(
        source=rollout.source,
        starts_in_motion=len(rollout.resting) - resting,
        starts_at_rest=resting,
        diverged=rollout.diverged,
        horizons=tuple(
            HorizonDocument(seconds, *(_spreads(rollout, seconds, resting) for resting in (False, True)))
            for seconds in rollout.horizons
        ),
        growth=rollout.growth,
        replay_relative=replay.relative,
        replay_joints=replay.joints,
        replay_strayed=replay.strayed,
    )


def _spreads(rollout: Rollout, seconds: float, resting: bool) -> dict[str, tuple[Number, Number]] | None:
    spreads = {by: rollout.spread(by, seconds, resting) for by in rollout.errors}
    return {by: (spread[0], spread[1]) for by, spread in spreads.items() if spread is not None} or None
