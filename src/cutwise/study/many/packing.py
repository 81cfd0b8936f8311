"""A study as one document that another process or machine can take up."""

from collections.abc import Callable
from typing import Any

from cutwise.io.scenario import read_document
from cutwise.study.many import distributions
from cutwise.study.many.definition import Aim, Between, Budget, Correlated, Design, Random, Search, Stop, Study

_LAWS: dict[str, Callable[..., Any]] = {
    law.__name__: law
    for law in (
        distributions.Normal, distributions.LogNormal, distributions.Uniform, distributions.Triangular,
        distributions.Empirical, distributions.Truncated, distributions.Reciprocal,
    )
}  # fmt: skip


def pack(study: Study) -> dict[str, Any]:
    """The study as plain values."""
    plain = study._asdict()
    plain["scenario"] = study.scenario.document()
    plain["coarse"] = None if study.coarse is None else study.coarse.document()
    plain["design"] = {key: list(lever.values) for key, lever in study.design.items()}
    plain["random"] = {
        key: [_law(lever.distribution), lever.added, list(lever.words), lever.curve]
        for key, lever in study.random.items()
    }
    if study.search is not None:
        plain["search"] = {
            **study.search._asdict(), "between": {key: list(one) for key, one in study.search.between.items()}
        }  # fmt: skip
    return plain


def unpack(plain: dict[str, Any]) -> Study:
    """The study of plain values."""
    given = dict(plain)
    given["scenario"] = read_document(plain["scenario"], plain["name"])
    given["coarse"] = None if plain["coarse"] is None else read_document(plain["coarse"], plain["name"])
    given["design"] = {key: Design(tuple(values)) for key, values in plain["design"].items()}
    given["random"] = {
        key: Random(_unlaw(law), added, tuple(words), curve)
        for key, (law, added, words, curve) in plain["random"].items()
    }
    given["correlated"] = tuple(
        Correlated(tuple(keys), tuple(tuple(row) for row in matrix)) for keys, matrix in plain["correlated"]
    )
    given["search"] = None if plain["search"] is None else _unsearch(plain["search"])
    given["given"] = tuple(plain["given"])
    given["measures"] = tuple(plain["measures"])
    given["stop"] = None if plain["stop"] is None else Stop(*plain["stop"])
    given["budget"] = None if plain["budget"] is None else Budget(*plain["budget"])
    return Study(**given)


def _unsearch(plain: dict[str, Any]) -> Search:
    between = {
        key: Between(low, high, whole, tuple(words)) for key, (low, high, whole, words) in plain["between"].items()
    }
    return Search(
        between, tuple(Aim(*aim) for aim in plain["aims"]), tuple(plain["probability"]), plain["runs"], plain["points"]
    )


def _law(one: Any) -> list[Any]:
    return [type(one).__name__, *(_law(part) if type(part).__name__ in _LAWS else part for part in one)]


def _unlaw(said: list[Any]) -> Any:
    name, *parts = said
    whole = [
        _unlaw(p) if isinstance(p, list) and p and p[0] in _LAWS else tuple(p) if isinstance(p, list) else p
        for p in parts
    ]
    return _LAWS[name](*whole)
