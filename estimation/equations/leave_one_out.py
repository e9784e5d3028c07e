"""Equations without each of their blocks of time."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Protocol, TypeVar, overload


class Mergeable(Protocol):
    """Equations that can be merged with others in the same parameters."""

    def merged_with(self, others: Sequence[Any]) -> Any:
        """Join the equations of others."""

    def emptied(self) -> Any:
        """No equation at all in the same parameters."""


_Part = TypeVar("_Part", bound=Mergeable)


class WithoutEach(Sequence[_Part]):
    """Equations without each of the blocks of time that make them up, merged when first asked for."""

    def __init__(self, blocks: Sequence[_Part], change: Callable[[_Part], _Part] | None = None) -> None:
        """Equations without each block, made when first asked for; a single block leaves none."""
        self._given, self._change = blocks, change

    def __len__(self) -> int:
        """Number of blocks."""
        return len(self._given)

    @cached_property
    def blocks(self) -> tuple[_Part, ...]:
        """The equations of each block."""
        blocks = self._given.blocks if isinstance(self._given, WithoutEach) else self._given
        return tuple(blocks) if self._change is None else tuple(map(self._change, blocks))

    @overload
    def __getitem__(self, place: int) -> _Part: ...

    @overload
    def __getitem__(self, place: slice) -> tuple[_Part, ...]: ...

    def __getitem__(self, place: int | slice) -> _Part | tuple[_Part, ...]:
        """All blocks but one."""
        return self._merged[place]

    @cached_property
    def _merged(self) -> tuple[_Part, ...]:
        """Merge what lies before and after each block once for all: 3 B merges instead of B^2."""
        after: list[list[_Part]] = [[]]
        for block in reversed(self.blocks[1:]):
            after.append([block.merged_with(after[-1])])
        before: list[_Part] = []
        without_each = []
        for block in self.blocks:
            others = [*before, *after.pop()]
            without_each.append(others[0].merged_with(others[1:]) if others else block.emptied())
            before = [before[0].merged_with([block])] if before else [block]
        return tuple(without_each)


def each(leave_one_out: Sequence[_Part], change: Callable[[_Part], _Part]) -> Sequence[_Part]:
    """What an operation that works row by row makes of equations without each block."""
    if isinstance(leave_one_out, WithoutEach):
        return WithoutEach(leave_one_out, change)
    return tuple(map(change, leave_one_out))
