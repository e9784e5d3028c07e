"""The operation list of a CasADi SX function, with every intermediate result assigned once."""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from .operations import BY_CODE


@dataclass(frozen=True)
class Step:
    """One operation: ``values[result] = name(*values[arguments])``."""

    name: str
    result: int
    arguments: tuple[int, ...]


@dataclass(frozen=True)
class Program:
    """What a function computes, one sample at a time.

    Attributes:
        inputs: value index -> row of the stacked inputs (all inputs one below the other).
        constants: value index -> number.
        steps: operations in order.
        outputs: value index of each non-zero output, in CasADi's order, outputs one below the other.
        input_sizes: size of each input.
    """

    inputs: dict[int, int]
    constants: dict[int, float]
    steps: tuple[Step, ...]
    outputs: tuple[int, ...]
    size: int
    input_sizes: tuple[int, ...]

    @cached_property
    def last_use(self) -> dict[int, int]:
        """Value index -> step after which nobody reads it; values that are output are not in it."""
        uses = {argument: k for k, step in enumerate(self.steps) for argument in step.arguments}
        outputs = set(self.outputs)
        return {value: k for value, k in uses.items() if value not in outputs}


def read_program(function: ca.Function) -> Program:
    """Read the operation list of an SX function.

    Raises:
        TypeError: if the function is not made of scalar (SX) operations or uses one that is not supported.
    """
    if not function.is_a("SXFunction"):
        raise TypeError(f"{function.name()} is not an SX function: expand() it first")
    sizes = tuple(function.nnz_in(k) for k in range(function.n_in()))
    rows = [sum(sizes[:k]) for k in range(len(sizes))]
    places = [0]
    for k in range(function.n_out()):
        places.append(places[-1] + function.nnz_out(k))
    register: dict[int, int] = {}
    inputs: dict[int, int] = {}
    constants: dict[int, float] = {}
    steps: list[Step] = []
    outputs = [-1] * places[-1]
    size = 0
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        source, target = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[places[target[0]] + target[1]] = register[source[0]]
            continue
        if code == ca.OP_INPUT:
            inputs[size] = rows[source[0]] + source[1]
        elif code == ca.OP_CONST:
            constants[size] = float(function.instruction_constant(k))
        elif code in BY_CODE:
            steps.append(Step(BY_CODE[code], size, tuple(register[s] for s in source)))
        else:
            raise TypeError(f"{function.name()} uses CasADi operation {code}, which the kernel does not know")
        register[target[0]] = size
        size += 1
    if -1 in outputs:
        raise TypeError(f"{function.name()} leaves an output unset")
    return Program(inputs, constants, tuple(steps), tuple(outputs), size, sizes)
