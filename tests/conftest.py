"""Robots, bodies, motions and reference data that the tests share."""

import gc
import os
import time
from collections.abc import Callable, Iterable, Iterator
from math import radians
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from dynident import model
from dynident.common.arrays import Array
from dynident.model.kernel import cache
from dynident.model.kernel.kernel import Kernel
from dynident.tests.frozen.inputs import folder_of_inputs
from hypothesis import settings
from matplotlib.figure import Figure

gc.set_threshold(100_000, 20, 20)
"""Thousands of tests live as long as the run: to look through them for waste takes a twentieth of it."""
os.environ["BROWSER"] = "true %s"
"""No test opens a window: this command does nothing, and succeeds."""
settings.register_profile("repeatable", deadline=None, derandomize=True, database=None)
settings.load_profile("repeatable")

Bodies = list[model.InertialParameters]


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder of real recordings."""
    folder = os.environ.get("DYNIDENT_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("real recordings: set DYNIDENT_DATA to their folder")
    return Path(folder)


def _turn(alpha: float = 0.0, d: float = 0.0, theta: float = 0.0, r: float = 0.0) -> model.Joint:
    return model.Joint("revolute", radians(alpha), d, radians(theta), r)


def _slide(alpha: float = 0.0, d: float = 0.0, theta: float = 0.0, r: float = 0.0) -> model.Joint:
    return model.Joint("prismatic", radians(alpha), d, radians(theta), r)


STANFORD = model.Robot("stanford", (_turn(), _turn(-90, r=0.2), _slide(90), _turn(), _turn(-90), _turn(90)))
SCARA = model.Robot("scara", (_turn(), _turn(d=0.4), _slide(d=0.3), _turn()))
# No angle or length special, two sliding joints, gravity oblique, every kind of drive term.
CROOKED = model.Robot(
    "crooked",
    (
        _slide(25, 0.1, 40, 0.2),
        _turn(-70, 0.3, 15, -0.1),
        _slide(50, -0.2, -80, 0.15),
        _turn(110, 0.25, 35, 0.05),
        _turn(-35, 0.12, 140, 0.3),
    ),
    gravity=(1.5, -3.0, -9.0),
    drives=model.Drives(
        offsets=True, coupling=model.Coupling((4, 5)), spring=model.Spring(2, 800.0, 0.2, (0.3, 0.15), radians(20))
    ),
)
PRISMATIC = {robot.name: robot for robot in (STANFORD, SCARA, CROOKED)}


ONE_OF_EACH = ("rx90", "ur10e", "panda", "crooked")
"""Robots of ``make test``: coupled drives, none, seven joints with link-side sensors, sliding joints."""
IN_FULL = ("rx90", "tx40", "ur10e", "panda")
"""Shipped robots that go through every test: coupled drives, offsets, seven joints with link-side sensors."""
ALL_ROBOTS = ("test_pinocchio.py", "test_robot_file.py")
"""Files whose tests take every shipped robot; compiled only for those above, for a compiler's time is long."""
FEW_STEPS = ("commands", "report")
"""Folders whose tests evaluate many models a few times each: to compile each would take longer."""
MANY_STEPS = ("simulate", "demo", "rollout", "identify")
"""Commands of thousands of steps, for which a compiler pays."""
FLAGS = cache._FLAGS
SAME_DIGITS = ("-O1", "-fexpensive-optimizations", "-fschedule-insns2", *FLAGS[1:])
"""Code of the same digits in half of a compiler's time, a tenth slower; ``tests/model`` has the package's own."""
UNCOMPILED = (
    "test_at_rest.py",
    "test_design.py",
    "test_effects.py",
    "test_gains.py",
    "test_gallery.py",
    "test_safe_runs.py",
)
"""Files whose tests take every shipped robot through much; further ones without a compiler, which takes longer."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out repetitions: the further arms differ from those in full by their lengths and axes alone."""
    selection = [item for item in items if _worth_it(item)]
    for item in selection:
        if _is_about({*model.robot_names(), *PRISMATIC}.difference(ONE_OF_EACH), item):
            item.add_marker(pytest.mark.long)
    selected = set(selection)
    config.hook.pytest_deselected(items=[item for item in items if item not in selected])
    items[:] = selection


def _worth_it(item: pytest.Item) -> bool:
    values = _values_of(item)
    robot = values.get("robot", values.get("shipped"))
    name = getattr(robot, "name", robot)
    if name in IN_FULL or name not in model.robot_names():
        return True
    return item.path.name in ALL_ROBOTS and values.get("compiled") != "compiled"


def _values_of(item: pytest.Item) -> dict[str, object]:
    """The values a test is repeated for, by the name of its argument."""
    return item.callspec.params if isinstance(item, pytest.Function) and hasattr(item, "callspec") else {}


def _is_about(robots: Iterable[str], item: pytest.Item) -> bool:
    """Tell whether a test is repeated for one of some robots."""
    values = (str(getattr(value, "name", value)) for value in _values_of(item).values())
    return not set(robots).isdisjoint(values)


def _of_all_workers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The temporary folder of a run of the tests, whichever of its parallel workers asks."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config) -> Iterator[None]:
    """Compiled code of the tests goes to a folder of its own, which parallel workers, and the next run, share."""
    kept = getattr(pytestconfig, "cache", None)  # emptied by --cache-clear
    folder = kept.mkdir("kernels") if kept else _of_all_workers(tmp_path_factory) / "kernels"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DYNIDENT_CACHE", str(folder))
        patch.setattr(cache, "_FLAGS", SAME_DIGITS)
        yield


@pytest.fixture(autouse=True)
def _kernels_of_one_kind(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Kernels made without a compiler are not kept for tests that have one: their last digits differ."""
    yield
    if os.environ.get("DYNIDENT_NO_COMPILER"):
        forget_kernels()


def forget_kernels() -> None:
    """Whatever is evaluated next is compiled, or not, as the environment then says."""
    from dynident.estimation.equations import observer
    from dynident.trajectories import simulation
    from dynident.trajectories.design import goal, limits, scene

    trajectory_code = goal.regressor_kernel, limits._kernel, scene._kernel, simulation._torque_code
    for cached in (*trajectory_code, observer.equation_code):
        cached.cache_clear()


@pytest.fixture(autouse=True)
def _without_compiler(request: pytest.FixtureRequest, root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No compiler for a few steps, and for robots that differ from those in full by lengths and axes alone."""
    folder, further = request.path.relative_to(root / "tests").parts[0], {*model.robot_names()}.difference(IN_FULL)
    many = request.node.get_closest_marker("many_steps") or _is_about(MANY_STEPS, request.node)
    few = folder in FEW_STEPS and not many
    if folder == "model":
        monkeypatch.setattr(cache, "_FLAGS", FLAGS)
    if few or (request.path.name in UNCOMPILED and _is_about(further, request.node)):
        monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")


@pytest.fixture
def drawn_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made, but written empty: to write them takes most of a page's time."""
    empty = property(lambda _: Figure(figsize=(1.0, 1.0)))
    monkeypatch.setattr("dynident.apps.report.blocks.Drawing.figure", empty)


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], object]], Path]:
    """``shared(name, fill)``: a folder that parallel workers share, filled by the first that asks for it.

    What is in it must be read only.
    """
    base = _of_all_workers(tmp_path_factory)

    def folder(name: str, fill: Callable[[Path], object]) -> Path:
        place, lock, beside = base / name, base / f"{name}.lock", base / f"{name}.part"
        while not place.exists():
            try:
                lock.mkdir()
            except FileExistsError:
                time.sleep(0.05)
                continue
            try:
                if not place.exists():
                    beside.mkdir()
                    fill(beside)
                    beside.rename(place)
            finally:
                lock.rmdir()
        return place

    return folder


@pytest.fixture(scope="module")
def inputs() -> Iterator[Path]:
    """The frozen runs' inputs in a folder of their own, which is the working folder."""
    with folder_of_inputs() as folder:
        yield folder


@pytest.fixture(scope="session")
def root() -> Path:
    """Root of the repository, which is the package."""
    return Path(__file__).parents[1]


@pytest.fixture(params=model.robot_names())
def shipped(request: pytest.FixtureRequest) -> model.Robot:
    """Each robot that comes with the package."""
    return model.load_robot(request.param)


@pytest.fixture(params=[*model.robot_names(), *PRISMATIC])
def robot(request: pytest.FixtureRequest) -> model.Robot:
    """Each shipped robot, and robots with sliding joints."""
    return PRISMATIC.get(request.param) or model.load_robot(request.param)


@pytest.fixture(scope="session")
def rx90() -> model.Robot:
    return model.load_robot("rx90")


@pytest.fixture(scope="session")
def prismatic() -> dict[str, model.Robot]:
    """Robots with sliding joints, by name."""
    return PRISMATIC


@pytest.fixture(params=["compiled", "numpy"])
def compiled(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Both ways in which a kernel works: compiled, and without a compiler."""
    if request.param == "numpy":
        monkeypatch.setenv("DYNIDENT_NO_COMPILER", "1")
        return False
    try:
        cache.compiled_library("void kernel(void) {}")
    except cache.CompilerUnavailable as reason:
        pytest.skip(f"compiled kernels cannot be tested here: {reason}")
    return True


@pytest.fixture
def evaluate(compiled: bool) -> Callable[..., Array]:
    """``evaluate(function, *inputs)``: first output on all samples by a kernel, shape (N, rows, columns)."""

    def dense(function: ca.Function, *inputs: Array) -> Array:
        kernel = Kernel(function)
        assert kernel.compiled == compiled
        entries = kernel(*inputs)
        result = np.zeros((entries.shape[1], *function.size_out(0)))
        result[:, kernel.rows, kernel.columns] = entries.T
        return result

    return dense


@pytest.fixture(scope="session")
def random_bodies() -> Callable[[int, int], Bodies]:
    """``random_bodies(count, seed)``: bodies that can exist, each made of six point masses."""

    def make(count: int, seed: int) -> Bodies:
        draw = np.random.default_rng(seed)
        clouds = zip(draw.uniform(0.1, 2.0, (count, 6)), draw.uniform(-0.3, 0.3, (count, 6, 3)), strict=True)
        return [point_cloud(masses, points) for masses, points in clouds]

    return make


def point_cloud(masses: Array, points: Array) -> model.InertialParameters:
    """Sums over the points, in the order of (6)."""
    x, y, z = points.T
    entries = (y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y, x, y, z, np.ones_like(x))
    return model.InertialParameters(np.array([masses @ entry for entry in entries]))


@pytest.fixture(scope="session")
def cloud() -> Callable[[Array, Array], model.InertialParameters]:
    """``cloud(masses, points)``: parameters of point masses [kg] at points [m], by direct sums."""
    return point_cloud


@pytest.fixture(scope="session")
def random_parameters(
    random_bodies: Callable[[int, int], Bodies],
) -> Callable[[model.Robot, int], dict[str, float]]:
    """``random_parameters(robot, seed)``: standard parameters of a robot that can exist, by name."""

    def make(robot: model.Robot, seed: int) -> dict[str, float]:
        draw = np.random.default_rng(seed + 1000)
        values = {name: float(draw.uniform(0.2, 2.0)) for name in model.standard_columns(robot)}
        for link, body in enumerate(random_bodies(robot.n, seed), start=1):
            values |= body.named(str(link))
        if robot.coupling:  # IA5 = K5^2 JA5 + K6^2 JA6 is larger than IA6, and FV5, FV6 hold FVM6
            first, second = robot.coupling.joints
            values[f"IA{first}"] += values[f"IA{second}"]
            for joint in (first, second):
                values[f"FV{joint}"] += values[f"FVM{second}"]
        return values

    return make
