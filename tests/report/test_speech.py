"""Answers show themselves: a line, the screen, a page, a frame, a format; and no answer imports the report."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dynident import InertialParameters, Simulator, answer_payload, identify, load_robot, payload_problem
from dynident.apps.logs.log_check import check_log
from dynident.apps.numbers import with_interval, with_sigma
from dynident.apps.report.blocks import COLUMNS, LINES
from dynident.common.errors import InputError
from dynident.common.schema import convert, read_json, write_json
from dynident.common.speech import Speaks
from dynident.estimation import GainsResult, PayloadAnswer
from dynident.estimation.answers.gains import GainsWorking
from dynident.estimation.payload.long_motion import Source
from dynident.estimation.results.payload import array, numbers
from dynident.model import Recording, Robot
from dynident.tests.common.test_wrong_files import filled
from dynident.trajectories import RX90_NOISE, random_via_points
from msgspec import inspect, structs

LOAD = InertialParameters.from_com(7.025, [0.0, 0.0, 0.143], [0.018, 0.018, 0.035])


@pytest.fixture(scope="module")
def answers() -> dict[str, Any]:
    """One of each kind, from one pair of recordings; the gains are made up."""
    robot = load_robot("rx90")
    arm, motion = Simulator(robot), random_via_points(robot, count=10, seed=0).motion(rate=200.0)
    unloaded, loaded = (arm.record(motion, load, RX90_NOISE, seed=k) for k, load in enumerate((None, LOAD)))
    problem = payload_problem(robot, [loaded], [unloaded])
    brief = slice(0, 2000)
    log = Recording(unloaded.t[brief], unloaded.q[brief], unloaded.torque[brief], source="brief.csv")
    return {
        "payload": answer_payload(problem),
        "robot": identify(robot, [unloaded]),
        "gains": drive_gains(robot),
        "log": check_log(robot, log),
    }


def drive_gains(robot: Robot) -> GainsResult:
    made = convert(filled(inspect.type_info(GainsResult)), GainsResult)
    working = GainsWorking(Source((), (), robot.processing), (), (), (), (), ())
    return structs.replace(made, robot=robot.name).made_by(working)


KINDS = ("payload", "robot", "gains", "log")


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_is_a_line_and_a_screen(kind: str, answers: dict[str, Speaks]) -> None:
    answer = answers[kind]
    assert "\n" not in repr(answer)
    assert len(repr(answer)) < 2 * COLUMNS
    lines = str(answer).split("\n")
    assert len(lines) <= LINES
    assert max(map(len, lines)) <= COLUMNS
    assert str(answer) == answer.summary()
    assert len(answer.summary(details=True)) > len(str(answer))


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_becomes_values_and_files(kind: str, answers: dict[str, Speaks], tmp_path: Path) -> None:
    answer = answers[kind]
    assert json.loads(json.dumps(answer.to_dict()))["robot"] == "rx90"
    answer.report(tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    block = answer._repr_html_()
    assert "<table" in block
    assert "<svg" in block or kind in ("gains", "log")
    assert "Verdict" in block or kind == "log"
    if kind != "gains":  # whose figures are of recordings that the verdict looks at
        assert answer.plot().axes
        assert "<svg" in answer.plot()._repr_svg_()
    with pytest.raises(InputError, match="there are "):
        answer.plot("no such figure")


@pytest.mark.parametrize("kind", ["payload", "robot", "gains"])
def test_a_result_read_back_is_of_the_same_type_and_shows_the_same(
    kind: str, answers: dict[str, Any], tmp_path: Path
) -> None:
    result = getattr(answers[kind], "result", answers[kind])
    write_json(tmp_path / "a.json", result)
    back = read_json(tmp_path / "a.json", type(result), "")
    shown = result.summary(details=True)
    assert shown == answers[kind].summary(details=True)
    without_advice = re.sub(r"add --json \S+, then ", "", " ".join(shown.split()))  # it comes from a file
    assert " ".join(back.summary(details=True).split()) == without_advice
    assert repr(back) == repr(result)
    assert back.to_dict() == result.to_dict()
    assert back.to_dict()["kind"] == kind
    assert back.working is None
    assert result.working is (answers[kind] if kind != "gains" else result.working)
    with pytest.raises(InputError, match="identify again"):
        back.report(tmp_path / "r.html")
    text = (tmp_path / "a.json").read_text().replace(f'"kind": "{kind}"', '"kind": "other"')
    (tmp_path / "b.json").write_text(text)
    with pytest.raises(InputError, match=f"is a result of the kind 'other', not '{kind}'"):
        read_json(tmp_path / "b.json", type(result), "")


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_becomes_a_frame(kind: str, answers: dict[str, Speaks]) -> None:
    pandas = pytest.importorskip("pandas")
    frame = answers[kind].to_frame()
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == 1 if kind == "gains" else len(frame) >= 6  # a motor; numbers of the first screen


def test_a_payload_by_name(answers: dict[str, PayloadAnswer]) -> None:
    answer = answers["payload"]
    payload, best = answer.result, answer.recommended
    assert payload.working is answer
    assert (payload.mass.low, payload.mass.high) == tuple(best.intervals.parameters[9])
    assert payload.mass.low < payload.mass.value < payload.mass.high
    assert payload.com.value[2] == best.body.com[2]
    assert (payload.inertia.low[0, 2], payload.inertia.high[0, 2]) == tuple(best.intervals.inertia_com[0, 2])
    assert (payload.mass.use == "use") == (answer.verdict.level != "do_not_use")
    assert (payload.inertia.use == "use") == (answer.verdict.level == "use")
    assert float(payload.mass) == answer.mass


def test_the_words_of_a_document_are_its_answers(answers: dict[str, Any]) -> None:
    """Its numbers are frozen."""
    payload, robot, arm = answers["payload"], answers["robot"], load_robot("rx90")
    for answer, steps in ((payload, payload.result.essential), (robot, robot.result.elimination)):
        result, settings = answer.result, answer.result.processing
        assert (result.robot_title, result.friction) == (arm.title, robot.choices)
        assert (settings.coulomb, settings.torque_side, settings.friction) == ("sum", "motor", ("FS", "FV"))
        assert (steps.rule, steps.description) == ("ratio", answer.elimination.rule.description)
        assert (steps.path[1].eliminated, steps.warnings) == (answer.elimination.order[0], answer.warnings)
        assert steps.parameters[0].name == "ZZ1R"
    rows = [(row.name, row.grouping) for row in robot.result.base_parameters]
    assert rows == list(zip(robot.base.names, robot.base.groupings(), strict=True))
    assert robot.result.joints == ("revolute",) * 6
    result, best = payload.result, payload.result.best
    assert (result.frame, result.flange_in_payload_frame.source) == (arm.payload_frame, arm.sources["flange"])
    assert (result.recommended.method, result.recommended.reason) == payload.recommendation
    assert "measures" in result.joint_that_agrees_least
    assert (best.interval95_by, best.active[0].constraint) == ("jackknife", best.constraints[0])


def test_details_hold_every_number_of_a_payload(answers: dict[str, PayloadAnswer]) -> None:
    """Of each method with the larger standard deviation, of the one to use with its interval."""
    result = answers["payload"].result
    shown = result.summary(details=True)
    for own in result.free:
        sigma = [*own.larger_sigma, *np.fmax(array(own.com_sigma, 3), array(own.com_sigma_robust, 3))]
        values = zip([*own.ten, *array(own.com, 3)], sigma, strict=True)
        assert all(str(with_sigma(x, one)) in shown for x, one in values), own.method
    assert result.best
    for x, (low, high) in zip(result.best.ten, numbers(result.best.interval95, 2), strict=True):
        assert all(text in shown for text in with_interval(x, low, high))


def test_gains_are_told_with_their_sigma() -> None:
    made = drive_gains(load_robot("rx90"))
    table = structs.replace(made.drive_gains, values=(10.0,), relative_covariance=((4e-4,),), rests_on=("gravity",))
    text = structs.replace(made, drive_gains=table).made_by(made.working).summary()
    assert re.search(r"1 +10\.000 +0\.2 +2 ", text), text


def test_a_payload_in_a_controllers_format(answers: dict[str, PayloadAnswer]) -> None:
    assert "set_target_payload" in answers["payload"].result.export("ur", despite_verdict=True)
    with pytest.raises(InputError, match="there is no format 'abc'"):
        answers["payload"].result.export("abc")
