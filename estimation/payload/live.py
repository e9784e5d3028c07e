"""A payload weighed while the robot works: samples go in, what is known of the payload and its changes come out."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from ...model import Recording
from ..signals.live import BlockCutter
from .change import Change, ChangeWatch
from .window import MovingWindow, Weighed


class Told(NamedTuple):
    """What one more block of motion says.

    ``time``: of the sample by which it was known [s]; ``weighed``: by the window; ``change``: one that was just
    found.
    """

    time: float
    weighed: Weighed
    change: Change | None = None


@dataclass
class LiveWeighing:
    """A window that begins anew where the payload changes.

    Attributes:
        changes: that were found so far, and when each was reported [s].
        latest: what the last block said; None before the first.
    """

    window: MovingWindow
    changes: list[tuple[Change, float]] = field(default_factory=list)
    latest: Told | None = None

    def __post_init__(self) -> None:
        """Begin to cut."""
        self._cutter = BlockCutter(self.window.processing)
        self._watch = ChangeWatch(self.window)

    def feed(self, recording: Recording) -> Iterator[Told]:
        """Take the next samples; gives what each block of motion says that they complete.

        Raises:
            InputError: if the samples cannot be filtered.
        """
        for data in self._cutter.feed(recording):
            block = self.window.block(data)
            if block is None:
                continue
            self.window.add(block)
            change = self._watch.change()
            if change is not None:
                self.changes.append((change, float(recording.t[-1])))
                # The block in which it changed holds both payloads.
                self.window.since(change.time + 0.5 * (block.stop - block.start))
            self.latest = Told(float(recording.t[-1]), self.window.weighed(), change)
            yield self.latest
