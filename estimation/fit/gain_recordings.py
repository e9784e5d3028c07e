"""Whether recordings are those that drive gains were identified from: then their errors are not independent."""

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

from ...model import Recording


class GainRecordings(NamedTuple):
    """Fingerprints of the recordings behind drive gains; empty where they were not read from a log."""

    unloaded: tuple[str, ...] = ()
    loaded: tuple[str, ...] = ()

    @staticmethod
    def of(unloaded: Sequence[Recording], loaded: Sequence[Recording]) -> "GainRecordings":
        """Of recordings without and with the known payload."""
        bare, heavy = (tuple(r.fingerprint for r in group if r.fingerprint) for group in (unloaded, loaded))
        return GainRecordings(bare, heavy)

    @staticmethod
    def read(told: Mapping[Literal["unloaded", "loaded"], tuple[str, ...]] | None) -> "GainRecordings":
        """Fingerprints as ``_asdict`` gives them; empty where there are none."""
        return GainRecordings(told.get("unloaded", ()), told.get("loaded", ())) if told else GainRecordings()

    def notes(
        self, loaded: Sequence[Recording], unloaded: Sequence[Recording], mass: float | None
    ) -> tuple[str, ...]:
        """What to say of recordings that are used again, one line each; empty if none is.

        Args:
            loaded: with the payload that is asked for.
            unloaded: without, or the robot's own.
            mass: of the payload that the gains were identified with [kg]; None where it is not known.
        """
        again = [r.source for r in loaded if r.fingerprint in self.loaded]
        if again:
            given = f", {mass:g} kg as given then" if mass is not None else ""
            return (
                f"These gains come from this same pair ({_named(again)}{given}): the mass is "
                "what was typed in, it confirms nothing. The intervals take the gains' errors and the recordings' "
                "for unrelated, which they are not. Record another payload.",
            )
        every = (*self.unloaded, *self.loaded)
        shared = [r.source for r in (*unloaded, *loaded) if r.fingerprint in every]
        if not shared:
            return ()
        return (
            f"{_named(shared)}: the gains were identified from it too; the intervals take its noise for unrelated "
            "to the gains' errors.",
        )


def _named(sources: Sequence[str]) -> str:
    return ", ".join(dict.fromkeys(sources))
