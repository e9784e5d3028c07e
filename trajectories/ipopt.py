"""IPOPT (Waechter and Biegler, an interior point method) through CasADi, on a design's sparse constraints.

Value, exact gradient and sparse Jacobian are handed over as callbacks; the Hessian is a limited-memory one.
"""

import io
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any

import casadi as ca
import numpy as np

from ..common.arrays import Array
from .constraints import Constraints
from .margins import Margins
from .problem import DesignProblem

_LARGE = 1e6  # stands for inf: the line search then goes back
_LOOK = 25  # iterations from one look at the motion to the next
_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "no_nlp_grad": True,
    "calc_lam_p": False,
    "show_eval_warnings": False,
    "iteration_callback_step": _LOOK,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.hessian_approximation": "limited-memory",
    "ipopt.limited_memory_max_history": 6,
    # The other form, by Sherman and Morrison, takes twice the time and finds the same.
    "ipopt.limited_memory_aug_solver": "extended",
    "ipopt.mu_strategy": "adaptive",
    "ipopt.bound_relax_factor": 0.0,
    "ipopt.tol": 1e-4,
}


class Ipopt:
    """Minimises a problem's criterion of one order and width.

    Attributes:
        evaluations: of criterion and gradient.
    """

    def __init__(self, problem: DesignProblem, constraints: Constraints, look: Callable[[Array], None]) -> None:
        """``look`` is shown a motion now and then while IPOPT runs."""
        self.evaluations = 0
        self._problem, self._constraints, self._look = problem, constraints, look
        self._order, self._width = 1.0, 0.0
        self._at: tuple[bytes, dict[str, Any]] = (b"", {})
        self._error: BaseException | None = None
        self._quiet, self._asked = ExitStack(), threading.Event()

    def minimise(self, x: Array, order: float, width: float, margins: Margins, iterations: int) -> Array:
        """Where IPOPT ends, started at x.

        Raises:
            KeyboardInterrupt: by Ctrl-C.
        """
        self._order, self._width, self._at, self._error = order, width, (b"", {}), None
        family, (low, high) = self._problem.family, self._constraints.bounds(margins)
        functions = self._functions()
        x_symbol = ca.MX.sym("x", family.size)
        problem = {"x": x_symbol, "f": functions["f"](x_symbol), "g": functions["g"](x_symbol)}
        own = {name: functions[name] for name in ("grad_f", "jac_g", "iteration_callback")}
        solver = ca.nlpsol("design", "ipopt", problem, {**_OPTIONS, **own, "ipopt.max_iter": iterations})
        with self._quiet, _deferred() as self._asked:
            answer = solver(x0=x, lbx=family.low, ubx=family.high, lbg=low, ubg=high)
        if self._error is not None:
            raise self._error
        if self._asked.is_set():  # after the last callback
            raise KeyboardInterrupt
        return np.clip(np.asarray(answer["x"]).ravel(), family.low, family.high)

    def _functions(self) -> dict[str, Any]:
        """What IPOPT calls."""
        (rows, size), starts, places = self._constraints.pattern
        x, one, g, none = (ca.Sparsity.dense(n, 1) for n in (size, 1, rows, 0))
        empty = ca.Sparsity(0, 0)
        jacobian = ca.Sparsity(rows, size, starts.tolist(), places.tolist())
        shapes = {"x": x, "f": one, "g": g, "lam_x": x, "lam_g": g, "lam_p": none}
        looked = [shapes[name] for name in ca.nlpsol_out()]

        def gradient(y: Any, _: Any) -> list[Any]:
            return list(self._get("value", y))

        def slopes(y: Any, _: Any) -> list[Any]:
            return [self._get("g", y), ca.DM(jacobian, self._get("jacobian", y))]

        def look(y: Any, *_: Any) -> list[Any]:
            self._look(np.asarray(y).ravel())
            return [0]

        return {
            "f": self._callback("f", [x], [one], lambda y: [self._get("value", y)[0]]),
            "g": self._callback("g", [x], [g], lambda y: [self._get("g", y)]),
            "grad_f": self._callback("grad_f", [x, empty], [one, x], gradient),
            "jac_g": self._callback("jac_g", [x, empty], [g, jacobian], slopes),
            "iteration_callback": self._callback("look", looked, [one], look),
        }

    def _callback(
        self, name: str, takes: Sequence[Any], gives: Sequence[Any], function: Callable[..., list[Any]]
    ) -> Any:
        """A CasADi function that calls back; whatever goes wrong in it stops IPOPT and is raised afterwards."""

        def evaluate(_: Any, given: Any) -> list[Any]:
            try:
                if self._asked.is_set():
                    raise KeyboardInterrupt
                return function(*given)
            except BaseException as error:
                self._error = error
                # This one stops IPOPT at once; what CasADi would print about it is not for the terminal.
                self._quiet.enter_context(redirect_stderr(io.StringIO()))
                self._quiet.enter_context(redirect_stdout(io.StringIO()))
                raise KeyboardInterrupt from error

        members = {
            "get_n_in": lambda _: len(takes),
            "get_n_out": lambda _: len(gives),
            "get_sparsity_in": lambda _, k: takes[k],
            "get_sparsity_out": lambda _, k: gives[k],
            "eval": evaluate,
        }
        callback = type("Callback", (ca.Callback,), members)()
        callback.construct(name, {})
        return callback

    def _get(self, what: str, y: Any) -> Any:
        """ "value" with its gradient, "g" or "jacobian" at y, each found once."""
        x = np.asarray(y).ravel()
        if x.tobytes() != self._at[0]:
            self._at = (x.tobytes(), {})
        found = self._at[1]
        if what not in found:
            found[what] = self._found(what, x)
        return found[what]

    def _found(self, what: str, x: Array) -> Any:
        if what == "value":
            self.evaluations += 1
            value, slope = self._problem.evaluate(x, self._order, self._width)
            return (value, slope) if np.isfinite(value) else (_LARGE, slope)
        if what == "state":
            return self._problem.state(x, self._width)
        state = self._get("state", x)
        if what == "g":
            return self._constraints.values(state)
        return self._constraints.jacobian(x, state, self._width)


@contextmanager
def _deferred() -> Iterator[threading.Event]:
    """Ctrl-C sets an event, for the next callback to see: raised within IPOPT it would be lost or printed.

    Outside the main thread nothing is changed: there Ctrl-C never comes.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return
    before = signal.signal(signal.SIGINT, lambda *_: asked.set())
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
