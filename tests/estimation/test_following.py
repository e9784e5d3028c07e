"""What the controller missed before and after: shares known beforehand, and logs that do not tell."""

from pathlib import Path

import numpy as np
import pytest
from dynident.apps.logs import with_flags
from dynident.apps.logs.following import Following, FollowingChange, following_change, read_following
from dynident.apps.logs.map import LogMap, read_log_map
from dynident.common.arrays import Array
from dynident.common.errors import InputError
from dynident.estimation.fit.covariance import student95
from dynident.model import Recording, Robot

RATE, SECONDS = 100.0, 12.0


def signals(seed: int) -> tuple[Array, Array, Array]:
    """Times, positions of six joints (joint 1 held), and errors of the order of a milliradian."""
    t = np.arange(int(RATE * SECONDS)) / RATE
    q = 0.4 * np.sin(np.outer(t, [0.0, 1.1, 1.7, 2.3, 0.9, 1.4]))
    draw = np.random.default_rng(seed)
    slow = np.cumsum(draw.standard_normal((len(t), 6)), axis=0)
    error = 1e-3 * (np.sin(np.outer(t, [1.0, 2.1, 2.7, 3.3, 1.9, 2.4])) + 0.02 * (slow - slow.mean(axis=0)))
    return t, q, error


def write(path: Path, share: float, reference: str = "qref", seed: int = 0) -> Path:
    t, q, error = signals(0)
    torque = 30.0 * np.cos(q) + np.random.default_rng(seed).standard_normal(q.shape)
    names, columns = ["t"], [t[:, None]]
    for prefix, values in (("q", q), ("tau", torque)):
        names += [f"{prefix}{j}" for j in range(1, 7)]
        columns.append(values)
    extra = {"qref": q + share * error, "tauref": torque - 1e3 * share * error}.get(reference)
    if extra is not None:
        names += [f"{reference}{j}" for j in range(1, 7)]
        columns.append(extra)
    np.savetxt(path, np.hstack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    return path


def change(folder: Path, robot: Robot, share: float, reference: str) -> FollowingChange:
    before = read_following(write(folder / "before.csv", 1.0, reference), robot)
    after = read_following(write(folder / "after.csv", share, reference, 1), robot)
    return following_change(before, after)


@pytest.mark.parametrize(("reference", "kind"), [("qref", "following error"), ("tauref", "unpredicted torque")])
def test_the_fall_is_the_share(tmp_path: Path, rx90: Robot, reference: str, kind: str) -> None:
    following = change(tmp_path, rx90, 0.6, reference)
    assert following.kind == kind
    assert [joint.name for joint in following.joints] == [f"joint {j}" for j in range(2, 7)]
    assert following.total.fall == pytest.approx(0.4, abs=0.01)
    assert following.total.interval[0] <= 0.41
    assert following.total.interval[1] >= 0.39
    assert following.total.clear == "fell"
    _, _, error = signals(0)
    scale = 1.0 if reference == "qref" else 1e3
    assert following.joints[0].before == pytest.approx(scale * np.sqrt(np.mean(error[:, 1] ** 2)), rel=0.02)


def test_a_rise_and_no_change(tmp_path: Path, rx90: Robot) -> None:
    assert change(tmp_path, rx90, 1.5, "qref").total.clear == "rose"
    same = change(tmp_path, rx90, 1.0, "qref").total
    assert same.fall == pytest.approx(0.0, abs=1e-9)


def test_torque_alone_is_called_torque(tmp_path: Path, rx90: Robot) -> None:
    assert change(tmp_path, rx90, 0.5, "none").kind == "torque"


def test_different_references_are_not_compared(tmp_path: Path, rx90: Robot) -> None:
    a = read_following(write(tmp_path / "a.csv", 1.0, "qref"), rx90)
    b = read_following(write(tmp_path / "b.csv", 1.0, "tauref"), rx90)
    with pytest.raises(InputError, match="same columns in both"):
        following_change(a, b)


@pytest.mark.parametrize(
    ("table", "reference", "kind", "size"),
    [
        ('[position_reference]\ncolumns = "target_q_{0}"\n', "qref", "following error", 1.0),
        (
            '[position_reference]\ncolumns = "target_q_{0}"\nunit = "deg"\n',
            "qref",
            "following error",
            180.0 / np.pi,
        ),
        ('[torque_reference]\ncolumns = "target_q_{0}"\nunit = "mN·m"\n', "tauref", "unpredicted torque", 1e3),
    ],
)
def test_references_that_a_log_map_names(
    tmp_path: Path, rx90: Robot, table: str, reference: str, kind: str, size: float
) -> None:
    """A log with other names and units says the same."""
    standard = write(tmp_path / "a.csv", 1.0, reference)
    rows = np.loadtxt(standard, delimiter=",", skiprows=1)
    rows[:, 13:] *= size
    names = standard.read_text(encoding="utf-8").splitlines()[0]
    for j in range(1, 7):
        names = names.replace(f"{reference}{j}", f"target_q_{j - 1}")
    np.savetxt(tmp_path / "b.csv", rows, delimiter=",", header=names, comments="", fmt="%.15g")
    (tmp_path / "map.toml").write_text(table, encoding="utf-8")
    log_map = read_log_map(tmp_path / "map.toml")
    plain, named = read_following(standard, rx90), read_following(tmp_path / "b.csv", rx90, log_map=log_map)
    assert plain.kind == named.kind == kind
    assert named.recording.torque == pytest.approx(plain.recording.torque, abs=1e-9)
    with pytest.raises(InputError, match=r"target_q_0.* missing"):
        read_following(standard, rx90, log_map=log_map)


def test_turned_joints_turn_what_was_predicted(tmp_path: Path, rx90: Robot) -> None:
    path = write(tmp_path / "a.csv", 1.0, "tauref")
    plain = read_following(path, rx90)
    turned = read_following(path, rx90, log_map=with_flags(LogMap(), signs=[-1.0] * 6))
    assert turned.recording.torque == pytest.approx(-plain.recording.torque)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[position_reference]\nunit = 'deg'\n", "name the columns"),
        ("[torque_reference]\ncolumns = 'x{}'\nunit = 'percent'\n", "percent of what"),
        ("[torque_reference]\ncolumns = 'x{}'\nside = 'motor'\n", "unknown"),
        ("[position_reference]\ncolumns = ['a', 'b']\n", "6 joints"),
    ],
)
def test_references_that_cannot_be(tmp_path: Path, rx90: Robot, table: str, words: str) -> None:
    (tmp_path / "map.toml").write_text(table, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_following(write(tmp_path / "a.csv", 1.0), rx90, log_map=read_log_map(tmp_path / "map.toml"))


def test_a_reference_of_some_joints_only(tmp_path: Path, rx90: Robot) -> None:
    path = write(tmp_path / "a.csv", 1.0, "qref")
    text = path.read_text(encoding="utf-8").replace("qref4", "other", 1)
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="qref4 missing"):
        read_following(path, rx90)


def test_too_short(tmp_path: Path, rx90: Robot) -> None:
    path = write(tmp_path / "a.csv", 1.0, "qref")
    lines = path.read_text(encoding="utf-8").splitlines()[:200]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    short = read_following(path, rx90)
    with pytest.raises(InputError, match="less than 4 s"):
        following_change(short, read_following(path, rx90))


def test_the_interval_is_as_wide_as_chance() -> None:
    """With white noise in both, the logarithm of the ratio of two root mean squares scatters by 1/sqrt(samples)."""
    t, q, _ = signals(0)
    widths = []
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal((2, *q.shape))
        before, after = (Following("torque", Recording(t, q, missed)) for missed in noise)
        low, high = following_change(before, after).total.interval
        widths.append(np.log(1.0 - low) - np.log(1.0 - high))
    moving = 5 * len(t)
    assert np.mean(widths) == pytest.approx(2.0 * student95(11) / np.sqrt(moving), rel=0.15)
