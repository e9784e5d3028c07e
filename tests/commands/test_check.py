"""``check`` without ``--robot``: what fits, what to mend first, and no log that it does not survive."""

from pathlib import Path

import pytest
from dynident.tests.commands.typed import typed


def survives(content: bytes, name: str) -> None:
    Path("log.csv").write_bytes(content)
    ended = typed("check log.csv --details")
    assert ended.status in (0, 1, 2), f"{name}: {ended.errors}"
    assert len(ended.errors) == (ended.status == 2), f"{name}: {ended.errors}"
    assert ended.status == 2 or "Good:" in ended.out or "Mend first:" in ended.out, name


@pytest.mark.parametrize(
    "content", [b"", b"\n", b",", b"t", b"\x00" * 100, b"\xff\xfe", b"t,q1\n", b"#\n#\n", b"{}", b"sep=;"]
)
def test_it_survives_next_to_nothing(here: Path, content: bytes) -> None:
    survives(content, repr(content))


def test_a_log_of_no_robot_says_what_is_in_it(here: Path) -> None:
    (here / "log.csv").write_text("t,x,y\n" + "".join(f"{0.01 * k},1,2\n" for k in range(100)))
    ended = typed("check log.csv --details")
    assert ended.status == 1
    assert "columns t, x, y Mend first:" in ended.text
    assert "missing" in ended.out
