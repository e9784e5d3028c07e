"""Documents of ``passport`` and of ``compare``."""

from ....common.schema import Document, Matrix, Vector
from ....estimation import Identification, PayloadAnswer
from ...fleet import Log, Passport
from ...fleet.answers import numbers_of
from ...fleet.comparing import Compared
from ...results.parts import Number, VerdictDocument
from .parts import verdict_document


class PassportParameter(Document, frozen=True):
    """A parameter as its passport's equations give it."""

    name: str
    value: Number
    interval95: tuple[Number, Number]


class PassportDocument(Document, frozen=True):
    """What a passport holds, and the answer by it alone."""

    kind: str
    robot: str
    robot_fingerprint: str
    recipe_fingerprint: str
    logs: tuple[Log, ...]
    versions: dict[str, str]
    about: dict[str, str]
    headline: str
    parameters: tuple[PassportParameter, ...]
    verdict: VerdictDocument


class OddDocument(Document, frozen=True):
    """A recording that differs from all others in a parameter, in standard deviations of the difference."""

    recording: str
    parameter: str
    sigmas: float


class ComparedDocument(Document, frozen=True):
    """Parameters by k recordings: values and standard deviations k x c, the rest c each."""

    recordings: tuple[str, ...]
    parameters: tuple[str, ...]
    values: Matrix
    sigma: Matrix
    pooled: Vector
    pooled_interval95: Matrix
    scatter: Vector
    odd: tuple[OddDocument, ...]


def passport_document(passport: Passport, answer: Identification | PayloadAnswer) -> PassportDocument:
    """What ``dynident passport show --json`` writes."""
    return PassportDocument(
        kind=passport.recipe.kind,
        robot=passport.robot.name,
        robot_fingerprint=passport.robot_fingerprint,
        recipe_fingerprint=passport.recipe.fingerprint,
        logs=passport.logs,
        versions=dict(passport.versions),
        about=dict(passport.about),
        headline=answer.headline,
        parameters=tuple(
            PassportParameter(number.name, number.value, (number.low, number.high)) for number in numbers_of(answer)
        ),
        verdict=verdict_document(answer.verdict),
    )


def compared_document(compared: Compared) -> ComparedDocument:
    """What ``dynident passport compare --json`` and ``dynident compare --json`` write."""
    return ComparedDocument(
        compared.sources,
        compared.names,
        compared.values,
        compared.sigma,
        compared.pooled,
        compared.interval95,
        compared.scatter,
        tuple(OddDocument(*odd) for odd in compared.odd),
    )
