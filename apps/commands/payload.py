"""``dynident payload`` and ``weigh``: a payload from recordings with and without it."""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, ClassVar

from cyclopts import Parameter

from ... import estimation
from ...common.errors import InputError
from .. import results, view
from ..report.sections.payload import payload_report
from . import values
from .entry import KNOWN, SETTING, about, note, status
from .options import EquationsFile, PageOptions, RecordingOptions, ViewOptions
from .values import Share, number, numbers, word

_KNOWN = Parameter(group=KNOWN)
_BOX, _CENTRED = "X0,X1,Y0,Y1,Z0,Z1", "X,Y,Z,A,B,C"
_bounds = word(values.bounds, "LEAST,MOST")
_box, _ellipsoid = (word(partial(numbers, count=6, layout=f"{form} [m]"), form) for form in (_BOX, _CENTRED))


class _Payload(ViewOptions, PageOptions, RecordingOptions):
    rules: ClassVar = {
        "free_friction": {"method": ("1", "all")},
        "essential": {"method": ("4", "all")},
        "scale_sigma": {"method": ("1", "4", "all")},
    }

    mass: Annotated[values.Weighed | None, _KNOWN] = None
    """Mass from a scale, and its standard deviation."""
    mass_bounds: Annotated[tuple[float | None, float | None] | None, _bounds, _KNOWN] = None
    """Least and largest mass; either may be omitted: ,3."""
    com_within: Annotated[tuple[float, ...] | None, _box, _KNOWN] = None
    """Box that contains the centre of mass."""
    ellipsoid: Annotated[tuple[float, ...] | None, _ellipsoid, _KNOWN] = None
    """Ellipsoid that contains the whole payload: centre and semi-axes."""
    friction_change: Share | None = None
    """How much friction may differ under load, 1 sigma; for methods 3 and 4, and for --robot-parameters (default:
    10%; 0: not at all)."""
    unloaded: values.DataFiles = ()
    """Recording without payload; repeatable."""
    loaded: values.LoadedFiles
    """Recording with payload; repeatable for the same payload, in the order of the --unloaded ones."""
    robot_parameters: values.RobotParametersFile | None = None
    """The --json file of 'dynident identify', instead of --unloaded."""
    max_mismatch: Annotated[float | None, word(number, "RAD"), SETTING] = None
    """Largest difference of position with and without payload after alignment, rms of the worst joint (payload:
    method 3; default: 0.01)."""
    tool_frame: values.ToolFrame | None = None
    validate: values.HeldOutFiles = ()
    """Recording without payload that is kept out of the fit to test it; repeatable."""
    method: Annotated[str, word(values.method, "NAME")] = "all"
    """known-robot (1), change (2), difference (3), global (4) or all (default); see docs/theory.md."""
    friction: values.FrictionTerms | None = None
    """Friction model, as for 'dynident identify'; --robot-parameters bring their own."""
    free_friction: Annotated[bool, SETTING] = False
    """Method 1: estimate friction under load from scratch."""
    scale_sigma: Share | None = None
    """How much the scale of the loaded torques may differ from that of the unloaded ones, 1 sigma; for methods 1
    and 4 (default: not at all)."""
    essential: Annotated[values.Essential | None, SETTING] = None
    """Method 4: eliminate parameters until the error's standard deviation has grown by this ratio (default: 1.02),
    or until all relative standard deviations are within a percentage such as 10%."""
    npz: EquationsFile | None = None

    def check(self) -> None:
        """Refuse recordings with a payload that nothing stands beside, and options that no method uses."""
        super().check()
        if self.robot_parameters:
            self.refuse("friction", "belongs to recordings without payload: the stored robot has its own")
        elif not self.unloaded:
            raise InputError(
                "give --unloaded recordings or --robot-parameters: without either nothing can be compared"
            )
        elif self.method in ("1", "2"):
            self.refuse("friction_change", "belongs to methods 3, 4 and to --robot-parameters: none is asked for")

    def __call__(self) -> bool:
        constraints, setup = self.constraints(), self.setup()
        unloaded, loaded, held_out = map(setup.read, (self.unloaded, self.loaded, self.validate))
        known = setup.stored.estimate if setup.stored else None
        with status("reading") as progress, about(fault=estimation.SolverError):  # constraints may leave no body
            methods = None if self.method == "all" else (int(self.method),)
            settings = self.settings(setup, progress, loaded, unloaded, methods=methods)
            problem = estimation.payload_problem(setup.robot, loaded, unloaded, known, settings)
            if methods is None and self.scale_sigma:
                note("--scale-sigma: methods 2 and 3 have no column for the scale of loaded torques: left out")
            result = estimation.answer_payload(problem, held_out, constraints).result
        self.give(payload_report(result, self.document), lambda: result, setup.in_words())
        if self.npz:
            results.write_npz(self.npz, estimation.payload_system(problem))
        self.write_view(lambda: view.view_of_answer(setup.robot, loaded[0], result))
        return result.verdict.level != "do_not_use"

    def constraints(self) -> list[estimation.Constraint]:
        """The constraints that are named."""
        constraints: list[estimation.Constraint] = [estimation.PossibleBody()]
        if self.mass is not None:
            mass, sigma = self.mass
            if sigma is None:
                raise InputError(
                    "--mass needs the accuracy of the scale too: give the mass and its standard deviation in kg, "
                    f"such as {mass:g}+-0.01"
                )
            constraints.append(estimation.KnownMass(mass, sigma))
        if self.mass_bounds is not None:
            least, most = self.mass_bounds
            with about("--mass-bounds"):
                constraints.append(estimation.MassBounds(least or 0.0, math.inf if most is None else most))
        if self.com_within is not None:
            with about("--com-within"):
                constraints.append(estimation.CentreOfMassInBox(self.com_within[::2], self.com_within[1::2]))
        if self.ellipsoid is not None:
            with about("--ellipsoid"):
                constraints.append(estimation.InEllipsoid(self.ellipsoid[:3], self.ellipsoid[3:]))
        return constraints


_METHODS = ("tool_frame", "validate", "method", "friction", "free_friction", "scale_sigma", "essential", "npz")


class _Weigh(_Payload, without=_METHODS):
    # A difference of torques frees friction.
    rules: ClassVar = {
        **dict.fromkeys(("robot_parameters", "moving"), "static"),
        "friction_change": ("robot_parameters",),
    }

    moving: values.Joints | None = None
    """Joints that move (default: found in the recordings)."""
    static: bool = False
    """Weigh at rest: the arm stands still in poses, each reached from both sides (see near --static)."""
    inertia: Annotated[str | None, Parameter(metavar="box:AxBxC|cylinder:DxL")] = None
    """Assume the inertia of this body, in mm, if none is measured."""

    def __call__(self) -> bool:
        constraints = self.constraints()
        stand_in = estimation.StandIn.parse(self.inertia) if self.inertia is not None else None
        setup = self.setup()
        loaded, unloaded = setup.read(self.loaded), setup.read(self.unloaded)
        known = setup.stored.estimate if setup.stored else None
        with status("reading") as progress, about(fault=estimation.SolverError):  # constraints may leave no body
            settings = self.settings(setup, progress, loaded, unloaded, joints=self.moving)
            if self.static:
                result = estimation.weigh_at_rest(setup.robot, loaded, unloaded, constraints, settings)
            else:
                result = estimation.weigh(setup.robot, loaded, unloaded, known, constraints, settings)
            result = result.assuming(stand_in) if stand_in is not None else result
        spare = "--inertia is not needed: the inertia was measured well enough."
        measured = stand_in is not None and not result.assumed
        self.give(
            payload_report(result, self.document, [spare] if measured else []), lambda: result, setup.in_words()
        )
        self.write_view(lambda: view.view_of_answer(setup.robot, loaded[0], result))
        return result.verdict.level != "do_not_use"
