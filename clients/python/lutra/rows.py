"""Tables of comma-separated values as rows with types."""

from __future__ import annotations

import codecs
import csv
import http.client
from datetime import datetime, timezone
from typing import Any, Callable, Dict, Iterator, List, Mapping

from .errors import CutError

Row = Dict[str, Any]
CUT = "#ERROR"
"""What the last line of a table begins with that the server could not finish."""


def time(text: str) -> datetime:
    """ISO 8601 in UTC, as the server writes it."""
    text = text[:-1] if text.endswith("Z") else text
    layout = "%Y-%m-%dT%H:%M:%S.%f" if "." in text else "%Y-%m-%dT%H:%M:%S"
    return datetime.strptime(text, layout).replace(tzinfo=timezone.utc)


READERS: Mapping[str, Callable[[str], Any]] = {
    "integer": int,
    "number": float,
    "datetime": time,
    "time": time,
    "text": str,
    "string": str,
}
"""How a cell becomes a value, by the type that the server names for its column."""


def rows(answer: http.client.HTTPResponse, kinds: Mapping[str, str]) -> Iterator[Row]:
    """The rows of a table, read as they come. An empty cell is None; a column without a known type stays a text."""
    with answer:
        lines = csv.reader(_lines(answer))
        header = next(lines, [])
        readers: List[Callable[[str], Any]] = [READERS.get(kinds.get(name, ""), str) for name in header]
        for cells in lines:
            if cells and cells[0].startswith(CUT):
                raise CutError(",".join(cells))
            yield {name: read(cell) if cell else None for name, read, cell in zip(header, readers, cells)}


def _lines(answer: http.client.HTTPResponse) -> Iterator[str]:
    decode = codecs.getincrementaldecoder("utf-8")()
    rest = ""
    try:
        while chunk := answer.read1(1 << 16):
            text = rest + decode.decode(chunk)
            whole, end, rest = text.rpartition("\n")
            if end:
                yield from (line + "\n" for line in whole.split("\n"))
    except (http.client.HTTPException, OSError) as error:
        raise CutError(f"the table was cut: {error}") from error
    if rest:
        yield rest
