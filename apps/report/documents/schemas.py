"""JSON Schema of every document, for programs that read them."""

from pathlib import Path

import msgspec

from ....common.files import write_bytes
from ....common.schema import Document, json_schema
from ....estimation.results.payload import PayloadResult
from ....estimation.results.robot import GainsResult, RobotResult
from ...fleet.reduction import ReducedDocument
from ...logs.following import FollowingChange
from .check import CheckDocument, RobotCheckDocument
from .design import DesignDocument, NearDocument
from .fleet import ComparedDocument, FleetDocument
from .rollout import RolloutsDocument

DOCUMENTS: dict[str, type[Document]] = {
    "identify": RobotResult,
    "payload": PayloadResult,
    "weigh": PayloadResult,
    "gains": GainsResult,
    "design": DesignDocument,
    "near": NearDocument,
    "rollout": RolloutsDocument,
    "fleet_report": FleetDocument,
    "fleet_reduce": ReducedDocument,
    "compare": ComparedDocument,
    "check": CheckDocument,
    "verify": FollowingChange,
    "robot_check": RobotCheckDocument,
}
"""Each command's document by the command's name."""


def schema_text(name: str) -> bytes:
    """The JSON Schema of a command's document, as its file holds it."""
    text = msgspec.json.encode(json_schema(DOCUMENTS[name]), order="sorted")
    return msgspec.json.format(text, indent=1) + b"\n"


def write_schemas(folder: str | Path) -> None:
    """Write the JSON Schema of every document into a folder."""
    for name in DOCUMENTS:
        write_bytes(Path(folder) / f"{name}.schema.json", schema_text(name))


if __name__ == "__main__":
    write_schemas(Path(__file__).parents[3] / "docs" / "schemas")
