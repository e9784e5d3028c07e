"""A look at a log as JSON."""

from dataclasses import asdict
from typing import Any

from ..estimation.diagnosis import Finding, LogCheck


def check_document(check: LogCheck) -> dict[str, Any]:
    """One log's part of what ``dynident check --json`` writes."""
    return {
        "source": check.recording.source,
        "notes": list(check.recording.notes),
        "currents": check.currents,
        "usable": check.usable,
        "findings": [_finding(finding) for finding in check.findings],
        "time": asdict(check.time) if check.time else None,
        "joints": [asdict(facts) for facts in check.joints],
        "excitation": [asdict(entry) for entry in check.excitation],
        "relative_residual": check.relative_residual,
        "condition_number_scaled": check.condition_number_scaled,
    }


def _finding(finding: Finding) -> dict[str, str]:
    return {"severity": finding.severity, "words": finding.text}
