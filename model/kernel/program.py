"""The operation list of a CasADi SX function, the scalar operations it may hold, and how it is written as C.

C is written for several samples at once, with the call of the compiled result, or readably.
"""

import ctypes
import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import NamedTuple

import casadi as ca
import numpy as np

from ...common import Array
from .cache import compiled_library


class Operation(NamedTuple):
    """Operation on ``{0}`` and ``{1}``: in NumPy on arrays, in C on vectors."""

    numpy: str
    c: str


OPERATIONS: dict[str, Operation] = {
    "ASSIGN": Operation("{0}", "{0}"),
    "ADD": Operation("{0} + {1}", "{0} + {1}"),
    "SUB": Operation("{0} - {1}", "{0} - {1}"),
    "MUL": Operation("{0} * {1}", "{0} * {1}"),
    "DIV": Operation("{0} / {1}", "{0} / {1}"),
    "NEG": Operation("-{0}", "-{0}"),
    "SQ": Operation("{0} * {0}", "{0} * {0}"),
    "TWICE": Operation("{0} + {0}", "{0} + {0}"),
    "INV": Operation("1.0 / {0}", "1.0 / {0}"),
    "SIN": Operation("np.sin({0})", "vsin({0})"),
    "COS": Operation("np.cos({0})", "vcos({0})"),
    "SIGN": Operation("np.sign({0})", "vselect({0} > 0.0) - vselect({0} < 0.0) + vkeep({0} != {0}, {0})"),
    "POW": Operation("np.power({0}, {1})", "vpair(pow, {0}, {1})"),
    "CONSTPOW": Operation("np.power({0}, {1})", "vpair(pow, {0}, {1})"),
    "ATAN2": Operation("np.arctan2({0}, {1})", "vpair(atan2, {0}, {1})"),
    "NOT": Operation("({0} == 0.0) * 1.0", "vselect({0} == 0.0)"),
    "IF_ELSE_ZERO": Operation("np.where({0} != 0.0, {1}, 0.0)", "vkeep({0} != 0.0, {1})"),
}
for _name in ("fabs", "sqrt", "tan", "exp", "log", "sinh", "cosh", "tanh", "floor", "ceil"):
    OPERATIONS[_name.upper()] = Operation(f"np.{_name}({{0}})", f"veach({_name}, {{0}})")
for _name in ("sin", "cos", "tan"):
    OPERATIONS[f"A{_name.upper()}"] = Operation(f"np.arc{_name}({{0}})", f"veach(a{_name}, {{0}})")
for _name in ("fmin", "fmax"):
    OPERATIONS[_name.upper()] = Operation(f"np.{_name}({{0}}, {{1}})", f"vpair({_name}, {{0}}, {{1}})")
for _name, _sign in (("LT", "<"), ("LE", "<="), ("EQ", "=="), ("NE", "!=")):
    OPERATIONS[_name] = Operation(f"({{0}} {_sign} {{1}}) * 1.0", f"vselect({{0}} {_sign} {{1}})")
for _name, _sign in (("AND", "&"), ("OR", "|")):
    _both = f"({{0}} != 0.0) {_sign} ({{1}} != 0.0)"
    OPERATIONS[_name] = Operation(f"({_both}) * 1.0", f"vselect({_both})")

_BY_CODE = {getattr(ca, f"OP_{name}"): name for name in OPERATIONS}


class Step(NamedTuple):
    """Step of a program: ``values[result] = name(*values[arguments])``."""

    name: str
    result: int
    arguments: tuple[int, ...]


class Program(NamedTuple):
    """Operations that compute a function's outputs, one sample at a time."""

    inputs: dict[int, int]  # value index -> row of the stacked inputs (all inputs one below the other)
    constants: dict[int, float]  # value index -> number
    steps: tuple[Step, ...]  # operations in order
    outputs: tuple[int, ...]  # value index of each non-zero output, in CasADi's order, outputs one below the other
    input_sizes: tuple[int, ...]  # size of each input


def read_program(function: ca.Function) -> Program:
    """Read the operation list of an SX function.

    Raises:
        TypeError: if the function is not made of scalar (SX) operations or uses one that is not supported.
    """
    if not function.is_a("SXFunction"):
        raise TypeError(f"{function.name()} is not an SX function: expand() it first")
    sizes = tuple(function.nnz_in(k) for k in range(function.n_in()))
    rows = list(accumulate(sizes, initial=0))
    offsets = list(accumulate(map(function.nnz_out, range(function.n_out())), initial=0))
    register: dict[int, int] = {}
    inputs: dict[int, int] = {}
    constants: dict[int, float] = {}
    steps: list[Step] = []
    outputs = [-1] * offsets[-1]
    size = 0
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        source, target = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[offsets[target[0]] + target[1]] = register[source[0]]
            continue
        if code == ca.OP_INPUT:
            inputs[size] = rows[source[0]] + source[1]
        elif code == ca.OP_CONST:
            constants[size] = float(function.instruction_constant(k))
        elif code in _BY_CODE:
            steps.append(Step(_BY_CODE[code], size, tuple(register[s] for s in source)))
        else:
            raise TypeError(f"{function.name()} uses CasADi operation {code}, which the kernel does not know")
        register[target[0]] = size
        size += 1
    if -1 in outputs:
        raise TypeError(f"{function.name()} leaves an output unset")
    return Program(inputs, constants, tuple(steps), tuple(outputs), sizes)


_CHUNK = 128  # samples whose tiles stay in the processor's cache until they are turned into rows

_PRELUDE = """\
/* Generated by dynident. Structure of arrays, as many samples per instruction as one register holds. */
#include <math.h>
#include <string.h>

#if defined __AVX512F__
enum { LANES = 8 };
#elif defined __AVX__
enum { LANES = 4 };
#else
enum { LANES = 2 };
#endif
#define EACH_LANE(statement) { _Pragma("GCC unroll 8") for (int k_ = 0; k_ < LANES; ++k_) statement; }
typedef double reals __attribute__((vector_size(8 * LANES)));
typedef long long wholes __attribute__((vector_size(8 * LANES)));

static inline reals vload(const double *p, long long step) { reals x; EACH_LANE(x[k_] = p[k_ * step]) return x; }
static inline void vstore(double *p, reals x) { memcpy(p, &x, sizeof x); }
static inline reals vsplat(double x) { return x - (reals){0}; }
static inline reals vkeep(wholes mask, reals x) { return (reals)(mask & (wholes)x); }
static inline reals vselect(wholes mask) { return vkeep(mask, vsplat(1.0)); }
#define veach(f, x) ({ reals a_ = (x), r_; EACH_LANE(r_[k_] = f(a_[k_])) r_; })
#define vpair(f, x, y) ({ reals a_ = (x), b_ = (y), r_; EACH_LANE(r_[k_] = f(a_[k_], b_[k_])) r_; })

/* Cosine and sine: reduction by multiples of pi/2 in three parts, Taylor series on [-pi/4, pi/4]
   (remainder below 1e-18). Beyond 1e5 rad the C library answers. */
static const double SINE[] = {
  1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0,
  1.0 / 362880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0};
static const double COSINE[] = {
  1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
  1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0};
static inline reals vseries(reals z, const double *factors, int count) {
  reals sum = vsplat(factors[0]);
#pragma GCC unroll 8
  for (int k = 1; k < count; ++k) sum = sum * z + factors[k];
  return sum;
}
static inline int vhuge(reals x) {
  wholes far = (x > 1e5) | (x < -1e5) | (x != x);
  long long any = 0;
  EACH_LANE(any |= far[k_])
  return any != 0;
}
static inline reals vturn(reals x, int quarter) {
  const double magic = 6755399441055744.0; /* 1.5 * 2^52: adding it rounds to a whole number */
  reals shifted = x * 0.63661977236758134308 + magic;
  wholes k = (wholes)shifted + quarter;
  reals turns = shifted - magic;
  reals r = x - turns * 1.57079632673412561417e+00;
  r = r - turns * 6.07710050630396597660e-11;
  r = r - turns * 2.02226624879595063154e-21;
  reals z = r * r;
  reals s = r + r * z * vseries(z, SINE, 8);
  reals c = 1.0 - (0.5 * z - z * z * vseries(z, COSINE, 7));
  wholes odd = -(k & 1);
  reals y = (reals)((odd & (wholes)c) | (~odd & (wholes)s));
  return (reals)((wholes)y ^ ((k & 2) << 62));
}
static inline reals vsin(reals x) { return vhuge(x) ? veach(sin, x) : vturn(x, 0); }
static inline reals vcos(reals x) { return vhuge(x) ? veach(cos, x) : vturn(x, 1); }
"""

_LOOP = """
static const long long size[] = {{{sizes}}};
enum {{ inputs = {inputs}, outputs = {outputs}, widest = {widest}, tile = 8, chunk = {chunk} }};

/* Eight numbers of each output for every eight samples; in[k]: samples of input k, one after the other, step[k]
   numbers apart (0: all samples share it). What the last tile has to spare holds anything. */
static void tiles(const double *const *in, const long long *step, double *out, long long n) {{
  long long i = 0;
  for (; i + tile <= n; i += tile)
    for (int s = 0; s < tile; s += LANES) samples(in, step, i + s, out + i * outputs + s);
  if (i < n) {{
    double last[inputs][tile * widest];
    const double *rows[inputs];
    const int count = n - i;
    for (int k = 0; k < inputs; ++k) {{
      for (int s = 0; s < tile; ++s) {{
        const double *sample = in[k] + (i + (s < count ? s : count - 1)) * step[k];
        for (int c = 0; c < size[k]; ++c) last[k][s * size[k] + c] = sample[c];
      }}
      rows[k] = last[k];
    }}
    for (int s = 0; s < count; s += LANES) samples(rows, size, s, out + i * outputs + s);
  }}
}}

/* count steps one after the other, each a row of n numbers for every output; input k moves on by ahead[k] numbers
   a step. state: input 0, which takes the first outputs of each step, or 0. work: room for outputs x chunk. */
void run(const double *const *in, const long long *step, const long long *ahead, double *state, double *out,
         double *work, long long n, long long count) {{
  const double *from[inputs];
  for (long long i = 0; i < count; ++i, out += outputs * n) {{
    for (long long first = 0; first < n; first += chunk) {{
      const long long some = n - first < chunk ? n - first : chunk;
      for (int k = 0; k < inputs; ++k) from[k] = in[k] + i * ahead[k] + first * step[k];
      tiles(from, step, work, some);
      for (int r = 0; r < outputs; ++r) {{
        double *row = out + r * n + first;
        const double *tiled = work + r * tile;
        long long s = 0;
        for (; s + tile <= some; s += tile) memcpy(row + s, tiled + s * outputs, tile * sizeof(double));
        if (s < some) memcpy(row + s, tiled + s * outputs, (some - s) * sizeof(double));
      }}
    }}
    for (int r = 0; state && r < size[0]; ++r)
      for (long long s = 0; s < n; ++s) state[s * size[0] + r] = out[r * n + s];
  }}
}}
"""


def c_source(program: Program) -> str:
    """Write the program as one C file that exports ``run``."""
    lines = ["", "static void samples(const double *const *in, const long long *step, long long i, double *out) {"]
    entries = [(k, row) for k, size in enumerate(program.input_sizes) for row in range(size)]
    load = "vload(in[{0}] + i * step[{0}] + {1}, step[{0}])"
    lines += [f"  reals x{k} = {load.format(*entries[row])};" for k, row in program.inputs.items()]
    lines += [f"  reals x{k} = vsplat({c_number(value)});" for k, value in program.constants.items()]
    for step in program.steps:
        expression = OPERATIONS[step.name].c.format(*(f"x{k}" for k in step.arguments))
        lines.append(f"  reals x{step.result} = {expression};")
    lines += [f"  vstore(out + {8 * row}, x{k});" for row, k in enumerate(program.outputs)]
    loop = _LOOP.format(
        sizes=", ".join(map(str, program.input_sizes)),
        inputs=len(program.input_sizes),
        outputs=len(program.outputs),
        widest=max(program.input_sizes),
        chunk=_CHUNK,
    )
    return _PRELUDE + "\n".join(lines) + "\n}\n" + loop


def c_number(value: float) -> str:
    """Write a C constant that is exactly ``value``."""
    if math.isnan(value):
        return "NAN"
    return repr(value) if math.isfinite(value) else ("INFINITY" if value > 0 else "-INFINITY")


Fill = Callable[[Sequence[Array], Array, bool], None]
"""Function of inputs, of the array (steps x entries x N, C-contiguous) that it fills, and whether steps chain.

Inputs hold the samples of each step (steps x N x size), of all steps (N x size), or what all samples share (size,);
their last axes are C-contiguous. Where steps are chained the first one is the state, which ends as the last step
leaves it.
"""


def compiled_fill(program: Program) -> Fill:
    """Compile a program, or take the library from the cache.

    Raises:
        CompilerUnavailable: if there is no working C compiler.
    """
    size, run = len(program.outputs) * _CHUNK, compiled_library(c_source(program), "run").run
    pointer, number = ctypes.c_void_p, ctypes.c_longlong
    pointers, numbers = ctypes.POINTER(pointer), ctypes.POINTER(number)
    run.argtypes = [pointers, numbers, numbers, pointer, pointer, pointer, number, number]
    run.restype = None

    def fill(inputs: Sequence[Array], out: Array, chained: bool) -> None:
        # Addresses as numbers: a typed pointer takes longer to make than few samples take to evaluate.
        starts = (ctypes.c_void_p * len(inputs))(*(x.ctypes.data for x in inputs))
        apart = [x.shape[-1] if x.ndim >= 2 else 0 for x in inputs]
        ahead = [x.strides[0] // x.itemsize if x.ndim == 3 else 0 for x in inputs]
        numbers = ctypes.c_longlong * len(inputs)
        work, state = np.empty(size), inputs[0].ctypes.data if chained else 0
        steps, _, samples = out.shape
        arrays = starts, numbers(*apart), numbers(*ahead)
        run(*arrays, state, out.ctypes.data, work.ctypes.data, samples, steps)

    return fill


_WIDTH = 90  # largest length of expressions that are written where they are used, if only once
_PLAIN = r"[\w.]+(\[\d+\])?"
"""Pattern of operands that need no parentheses: a name, an entry of an array or a plain number."""

_SCALAR = (  # how the vector expressions read for a single number
    (r"v(?:each|pair)\((\w+), ", r"\1("),
    (r"v(sin|cos)\(", r"\1("),
    (r"vselect\(", "(double)("),
    (r"vkeep\((.*), (.*)\)", r"(\1 ? \2 : 0.0)"),
    (r" ([&|]) ", r" \1\1 "),
)


def c_body(function: ca.Function) -> list[str]:
    """Write the statements of a C function that computes the function's one output from its inputs.

    Inputs and output are arrays called as in the function, the output dense and row-major. What is used more than
    once is declared, the rest written where it is used.
    """
    program = read_program(function)
    names = [function.name_in(k) for k in range(function.n_in())]
    inputs = [(name, i) for name, size in zip(names, program.input_sizes, strict=True) for i in range(size)]
    uses = Counter(program.outputs)
    for step in program.steps:
        for index, argument in enumerate(step.arguments):
            uses[argument] += OPERATIONS[step.name].c.count(f"{{{index}}}")
    values = {k: "{}[{}]".format(*inputs[row]) for k, row in program.inputs.items()}
    values |= {k: c_number(number) for k, number in program.constants.items()}
    lines: list[str] = []
    for step in program.steps:
        text = OPERATIONS[step.name].c
        for pattern, replacement in _SCALAR:
            text = re.sub(pattern, replacement, text)
        operands = (values[k] for k in step.arguments)
        text = text.format(*(value if re.fullmatch(_PLAIN, value) else f"({value})" for value in operands))
        if uses[step.result] > 1 or len(text) > _WIDTH:
            name = f"x{len(lines)}"
            lines.append(f"const double {name} = {text};")
            text = name
        values[step.result] = text
    output, (rows, columns) = function.name_out(0), function.size_out(0)
    sparsity = function.sparsity_out(0).get_triplet()
    entries = sorted((row * columns + column, k) for k, (row, column) in enumerate(zip(*sparsity, strict=True)))
    read = {argument for step in program.steps for argument in step.arguments} | set(program.outputs)
    used = {inputs[row][0] for value, row in program.inputs.items() if value in read}
    head = [f"(void){name};" for name in names if name not in used]
    if len(entries) < rows * columns:
        head.append(f"for (int k = 0; k < {rows * columns}; ++k) {output}[k] = 0.0;")
    return [*head, *lines, *(f"{output}[{index}] = {values[program.outputs[k]]};" for index, k in entries)]
