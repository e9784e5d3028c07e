"""``dynident apply`` against the player: what is sent, what is read back, and all that is refused before a byte."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from dynident.apps import live
from dynident.cli import main
from dynident.tests.frozen.inputs import filed
from dynident.tests.live.conftest import Play, Played

Write = Callable[..., str]
PARAMETERS = {"XX": 0.06, "XY": 0.002, "XZ": 0.0, "YY": 0.07, "YZ": 0.0, "ZZ": 0.03}
PARAMETERS |= {"MX": 0.031, "MY": -0.062, "MZ": 0.31, "M": 3.1}


@pytest.fixture
def payload(tmp_path: Path) -> Write:
    """Writes a document of a payload."""

    def write(**changes: Any) -> str:
        document = {
            "robot": "ur10e",
            "frame": "tool0: the bare flange",
            "rated_payload_kg": 12.5,
            "estimates": [{"method": 1, "estimator": "wls", "parameters": PARAMETERS, "com": [0.01, -0.02, 0.1]}],
            "verdict": {"level": "use", "reasons": []},
        } | changes
        (tmp_path / "p.json").write_text(json.dumps(document))
        return str(tmp_path / "p.json")

    return write


def apply(player: Played, path: str, *more: str) -> int:
    line = ["apply", path, "--to", "ur", *player.address, f"script-port={player.script_port}", *more]
    return main(filed(line))


def scripts(player: Played) -> list[dict[str, Any]]:
    return [event for event in player.events() if event["event"] == "script"]


def test_the_payload_is_sent_and_read_back(play: Play, payload: Write, capsys: Any) -> None:
    player = play()
    assert apply(player, payload(), "--yes") == 0
    out, err = capsys.readouterr()
    assert "set_target_payload(3.1, [0.01, -0.02, 0.1]" in out
    assert "shows this payload now" in out
    assert not err
    (sent,) = scripts(player)
    assert not sent["refused"]
    assert sent["text"] in out
    assert sent["text"].startswith("sec ")


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        ("wrong payload", "payload 3.35 instead of 3.1"),
        ("wrong inertia", "payload_inertia"),
        ("local mode", "is it in remote control?"),
        ("refuses scripts", "nothing was sent; switch the controller to remote control"),
        ("refused", "no connection"),
        ("deaf", "no answer within"),
    ],
)
def test_what_is_not_there_afterwards_is_told(
    fault: str, why: str, play: Play, payload: Write, capsys: Any
) -> None:
    begin = time.monotonic()
    assert apply(play(fault=fault), payload(), "--yes") == 2
    assert time.monotonic() - begin < 5.0
    err = capsys.readouterr().err
    assert why in err
    assert len(err.splitlines()) == 1


REFUSED: dict[str, tuple[dict[str, Any], tuple[str, ...], int, str]] = {
    "without the word": ({}, (), 0, "nothing was sent"),
    "do not use": ({"verdict": {"level": "do_not_use", "reasons": []}}, ("--yes",), 1, "not sent: the verdict"),
    "another frame": ({"frame": "gripper"}, ("--yes",), 2, "not the flange: nothing was sent"),
    "too heavy": ({"rated_payload_kg": 2.0}, ("--yes",), 2, "the arm carries 2 kg"),
    "too heavy, insisted": ({"rated_payload_kg": 2.0}, ("--yes", "--despite-verdict"), 2, "the arm carries 2 kg"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_before_a_byte_is_sent(name: str, play: Play, payload: Write, capsys: Any) -> None:
    changes, more, status, why = REFUSED[name]
    player = play()
    assert apply(player, payload(**changes), *more) == status
    assert why in capsys.readouterr().err
    assert player.events() == []


@pytest.mark.parametrize(
    "command",
    ["movej([0,0,0,0,0,0])", "set_target_payload(1)\n  movej([0])", "set_target_payload(get_x(), [0,0,0])", ""],
)
def test_no_other_program_can_be_made(command: str) -> None:
    with pytest.raises(ValueError, match="not a payload"):
        live.program(command)
