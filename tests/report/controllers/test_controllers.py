"""Every format is parsed back to the same body; what a controller would refuse is refused before."""

import re
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from dynident.apps.commands.export import Name
from dynident.apps.export.controllers import FORMATS
from dynident.apps.export.load import ControllerLoad, HalfWidths
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.model import InertialParameters
from dynident.tests.report.controllers.parsers import MOMENTS_ONLY, PARSERS
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

SOURCE = "p.json, method 4 (constrained)"


def load_of(body: InertialParameters, **more: object) -> ControllerLoad:
    return replace(ControllerLoad(body, "tool0: flange", SOURCE, "use"), **more)  # type: ignore[arg-type]


def heads(name: str, load: ControllerLoad) -> list[str]:
    form = FORMATS[name]
    return list(form.head(form, form.ready(load)))


def elements(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def bodies(draw: st.DrawFn) -> InertialParameters:
    """Sums of two to six point masses: thin, flat and full bodies."""
    count = draw(st.integers(2, 6))
    masses = draw(arrays(np.float64, count, elements=elements(0.1, 10.0)))
    points = draw(arrays(np.float64, (count, 3), elements=elements(-0.5, 0.5)))
    com = masses @ points / masses.sum()
    arms = points - com
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arms, strict=True))
    assume(np.trace(inertia) > 1e-6)
    return InertialParameters.from_com(float(masses.sum()), com, inertia)


@st.composite
def frames(draw: st.DrawFn) -> tuple[Array, Array]:
    turn = draw(arrays(np.float64, 3, elements=elements(-3.0, 3.0)))
    return Rotation.from_rotvec(turn).as_matrix(), draw(arrays(np.float64, 3, elements=elements(-1.0, 1.0)))


def check(name: str, load: ControllerLoad, body: InertialParameters) -> None:
    """The parsed body is the given one: to ten digits, and 1e-6 of the trace for bodies at the edge."""
    parsed = PARSERS[name](FORMATS[name].text(load))
    assert parsed.mass == pytest.approx(body.mass, rel=1e-9)
    np.testing.assert_allclose(parsed.com, body.com, atol=1e-9 * (1.0 + np.abs(body.com).max()))
    given_inertia = np.diag(np.diag(body.inertia_com)) if name in MOMENTS_ONLY else body.inertia_com
    trace = float(np.trace(body.inertia_com))
    np.testing.assert_allclose(parsed.inertia, given_inertia + load.widened * np.eye(3), atol=1e-8 * trace + 1e-14)
    assert load.widened <= 1.1e-6 * trace


def test_there_is_a_parser_for_every_format_and_help_names_them_all() -> None:
    assert list(get_args(Name)) == list(FORMATS)
    assert set(PARSERS) == set(FORMATS)


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=40)
@given(body=bodies(), frame=frames())
def test_parsed_back(name: str, body: InertialParameters, frame: tuple[Array, Array]) -> None:
    R, p = frame
    load = load_of(body.moved(R, p)).seen_from(R, p, "flange")
    check(name, load, body)


SPECIAL = {
    "unlike entries": InertialParameters.from_com(
        2.5, [0.03, -0.02, 0.12], [[0.031, 0.002, -0.004], [0.002, 0.027, 0.003], [-0.004, 0.003, 0.019]]
    ),
    "ball": InertialParameters.from_com(2.0, [0.0, 0.0, 0.1], 0.002 * np.eye(3)),
    "two equal moments, oblique": InertialParameters.from_com(
        3.0, [0.1, 0.0, 0.1], 0.02 * np.eye(3) + 0.01 * np.outer([0.6, 0.0, 0.8], [0.6, 0.0, 0.8])
    ),
    "nearly a ball": InertialParameters.from_com(2.0, [0.0, 0.0, 0.1], 0.002 * np.eye(3) + 1e-17 * np.ones((3, 3))),
    "disc": InertialParameters.from_com(3.0, [0.0, 0.0, 0.05], np.diag([0.01, 0.01, 0.02])),
    "rod": InertialParameters.from_com(1.0, [0.2, 0.0, 0.0], np.diag([0.0, 0.01, 0.01])),
    "long way round": InertialParameters.from_com(
        1.0, [0.0, 0.0, 0.0], Rotation.from_euler("ZYX", [170, 90, 35], degrees=True).as_matrix()
        @ np.diag([0.01, 0.02, 0.025])
        @ Rotation.from_euler("ZYX", [170, 90, 35], degrees=True).as_matrix().T,
    ),
    "tiny": InertialParameters.from_com(1e-3, [1e-4, 0.0, 2e-4], 1e-9 * np.diag([1.0, 1.2, 1.4])),
    "large": InertialParameters.from_com(2300.0, [0.1, -0.4, 1.2], np.diag([120.0, 90.0, 110.0])),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("special", SPECIAL)
def test_special_bodies(name: str, special: str) -> None:
    check(name, load_of(SPECIAL[special]), SPECIAL[special])


@pytest.mark.parametrize("name", FORMATS)
def test_mass_and_com_only(name: str) -> None:
    """No number of the inertia appears, and the file says what it does instead."""
    body = SPECIAL["unlike entries"]
    load = load_of(body, point_mass=True, verdict="mass_and_com_only", reasons=("method 1 is vague",))
    text = FORMATS[name].text(load)
    parsed = PARSERS[name](text)
    assert parsed.mass == pytest.approx(2.5)
    np.testing.assert_allclose(parsed.com, body.com, atol=1e-9)
    np.testing.assert_allclose(parsed.inertia, np.zeros((3, 3)), atol=1e-16)
    head = "\n".join(heads(name, load))
    assert "Mass and centre of mass only: " in head
    assert "method 1 is vague" in head


@pytest.mark.parametrize("name", FORMATS)
def test_the_file_says_what_its_numbers_mean(name: str) -> None:
    form, load = FORMATS[name], load_of(SPECIAL["unlike entries"])
    head = heads(name, load)
    for word in ("dynident", SOURCE, "Verdict: use", "Frame: tool0", "Reference: ", "Order: ", "Units: ", "kg"):
        assert word in "\n".join(head), word
    assert all(line.strip() in form.text(load) for line in head)
    assert form.text(load).endswith("\n")
    assert form.text(load).isascii()
    assert not re.search(r"\bnan\b|\binf\b|-0\.0\b", form.text(load))


@pytest.mark.parametrize("name", FORMATS)
@settings(max_examples=25)
@given(body=bodies(), exponents=st.tuples(*3 * [st.floats(-4.0, -1.0)]))
def test_numbers_are_rounded_to_what_their_intervals_support(
    name: str, body: InertialParameters, exponents: tuple[float, float, float]
) -> None:
    """Within a tenth of the half-width (an inertia that must stay possible within five), and no body impossible."""
    trace = float(np.trace(body.inertia_com))
    halves = HalfWidths(10.0 ** exponents[0], 10.0 ** (exponents[1] - 1.0), trace * 10.0 ** (exponents[2] - 1.0))
    assume(halves.inertia > 1e-7)
    load = load_of(body, half_widths=halves)
    assume(load.rounded().mass > 0.0)
    parsed = PARSERS[name](FORMATS[name].text(load))
    assert parsed.mass == pytest.approx(body.mass, abs=0.1 * halves.mass)
    np.testing.assert_allclose(parsed.com, body.com, atol=0.1 * halves.com)
    theirs = np.diag(np.diag(body.inertia_com)) if name in MOMENTS_ONLY else body.inertia_com
    np.testing.assert_allclose(parsed.inertia, theirs, atol=0.5 * halves.inertia)
    assert load.rounded().body.physically_consistent


def test_a_thin_body_stays_possible_and_it_is_told() -> None:
    """A rod of 0.2 g m^2: with three decimals its moments would be 0, 0, 0."""
    rod = InertialParameters.from_com(1.0, [0.0, 0.0, 0.1], [0.0, 0.0104, 0.0104])
    load = load_of(rod, half_widths=HalfWidths(0.01, 0.001, 0.03))
    assert "[0.001, 0.011, 0.011" in FORMATS["ur"].text(load)
    assert "0.001 kg m^2 added to each moment" in "\n".join(heads("ur", load))


def test_a_rounded_flat_body_tells_all_that_was_added() -> None:
    """What makes a plate possible, and what rounding adds to it, are both in the moments that are written."""
    plate = InertialParameters.from_com(4.0, [0.0, 0.0, 0.1], [1.0, 2.0, 3.0])
    load = load_of(plate, half_widths=HalfWidths(0.01, 0.001, 3e-7)).rounded()
    digits = load.inertia_digits
    assert digits is not None
    assert load.widened > 5e-6, "a millionth of the moments' sum, and a unit"
    np.testing.assert_allclose(np.diag(load.inertia) - [1.0, 2.0, 3.0], load.widened, atol=0.51 * 10.0**-digits)


def test_what_is_lost_without_products_is_told() -> None:
    """Largest product 0.004 over the smallest moment 0.019: 21 %."""
    for name in MOMENTS_ONLY:
        assert "21 % of the smallest moment" in FORMATS[name].text(load_of(SPECIAL["unlike entries"]))
    assert "Products" not in FORMATS["ur"].text(load_of(SPECIAL["unlike entries"]))


def test_units() -> None:
    """Millimetres, centimetres, kgf cm s^2 and a stage in centimetres, by hand."""
    load = load_of(SPECIAL["unlike entries"])
    assert "[30.0, -20.0, 120.0]" in FORMATS["abb"].text(load)
    assert "X 30.0,Y -20.0,Z 120.0" in FORMATS["kuka"].text(load)
    assert re.search(r"CENTER X +\[cm\] +3\.0\n", FORMATS["fanuc"].text(load))
    assert re.search(r"INERTIA X +\[kgfcms\^2\] +0\.3161120", FORMATS["fanuc"].text(load))  # 0.031 / 0.0980665
    ball = replace(load_of(SPECIAL["ball"]), meters_per_unit=0.01)
    text = FORMATS["usd"].text(ball)
    assert "centerOfMass = (0.0, 0.0, 10.0)" in text
    assert "diagonalInertia = (20.0, 20.0, 20.0)" in text
    check("usd", ball, SPECIAL["ball"])


@pytest.mark.parametrize(
    ("vector", "words"),
    [
        ([0.01, 0, 0, 0.01, 0, 0.01, 0, 0, 0, 0.0], "a mass of 0 kg"),
        ([0.01, 0, 0, 0.01, 0, 0.01, 0, 0, 0, -2.0], "a mass of -2 kg"),
        ([0.01, 0, 0, 0.01, 0, 0.05, 0, 0, 0, 2.0], "no body has this inertia"),
    ],
)
def test_impossible_bodies_are_refused(vector: list[float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_of(InertialParameters(np.array(vector)))


def test_limits_of_the_formats() -> None:
    heavy = load_of(InertialParameters.from_com(4000.0, [0, 0, 1.0], np.diag([140.0, 130.0, 135.0])))
    with pytest.raises(InputError, match="refuses more than 133"):
        FORMATS["ur"].text(heavy)
    point = load_of(InertialParameters.from_com(1.0, [0, 0, 0.1], np.zeros((3, 3))))
    with pytest.raises(InputError, match="MuJoCo refuses"):
        FORMATS["mjcf"].text(point)
    with pytest.raises(InputError, match="metres per unit must be positive"):
        replace(point, meters_per_unit=0.0)


@pytest.mark.parametrize("name", FORMATS)
def test_hostile_names_stay_in_their_comment(name: str) -> None:
    """A file name cannot end a comment, start a line of code or leave ASCII."""
    source = "a--->\n*/ x := 1;\x1b[2J\x01\\"
    load = replace(load_of(SPECIAL["unlike entries"]), source=source, frame='tool0 µ "quoted"')
    check(name, load, SPECIAL["unlike entries"])
    text = FORMATS[name].text(load)
    assert text.isascii()
    assert "".join(text.split("\n")).isprintable()
    assert not any(line.startswith(("*/", " x")) for line in text.splitlines())
