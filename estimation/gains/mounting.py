"""Which of the loaded recordings have the weight at the same place."""

from collections.abc import Sequence
from typing import NamedTuple

from ...common.errors import InputError
from .known_load import KnownLoad


class Mountings(NamedTuple):
    """One number for each loaded recording: equal ones share a centre of mass.

    ``numbers``: as given; ``paired``: whether each loaded recording has one without payload of its own.
    """

    numbers: tuple[int, ...] = (1,)
    paired: bool = True

    @staticmethod
    def of(numbers: Sequence[int], loaded: int, unloaded: int) -> "Mountings":
        """Numbers for this many recordings with and without payload; all in one mounting by default.

        Raises:
            InputError: if there are not as many numbers as loaded recordings.
        """
        if numbers and len(numbers) != loaded:
            raise InputError(
                f"{len(numbers)} numbers of mountings for {loaded} loaded recording{'s' * (loaded != 1)}: give "
                "one number for each of them, in their order, such as 1,2,2 (--mounting)"
            )
        return Mountings(tuple(numbers) or (1,) * loaded, loaded == unloaded or len(set(numbers)) < 2)

    @property
    def names(self) -> tuple[int, ...]:
        """The mountings' numbers, each once, in the order in which they come."""
        return tuple(dict.fromkeys(self.numbers))

    @property
    def places(self) -> tuple[tuple[int, ...], ...]:
        """The loaded recordings of each mounting, counted from 0."""
        return tuple(tuple(k for k, number in enumerate(self.numbers) if number == name) for name in self.names)

    def loads(self, load: KnownLoad | Sequence[KnownLoad]) -> tuple[KnownLoad, ...]:
        """What is known of the payload in each mounting.

        Args:
            load: the same in all, or one for each mounting.

        Raises:
            InputError: if they are another number, or a centre of mass is given for several mountings.
        """
        many = len(self.names)
        loads = (load,) * many if isinstance(load, KnownLoad) else tuple(load)
        if len(loads) != many:
            raise InputError(f"{len(loads)} known payloads for {many} mountings: give one, or one for each")
        if isinstance(load, KnownLoad) and many > 1 and load.com is not None:
            raise InputError(
                "one centre of mass cannot hold in several mountings: leave com and inertia_com out, or give one "
                "mounting"
            )
        return loads
