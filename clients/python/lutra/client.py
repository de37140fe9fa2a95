"""A server as a person asks it, and a shared link."""

from __future__ import annotations

import json
import os
import urllib.parse
from datetime import datetime, timezone
from typing import Any, Dict, Iterable, Iterator, List, Optional, Union

from .errors import LutraError
from .files import Downloaded, download, published_sha256
from .http import Connection, Each
from .rows import Row, rows

Time = Union[datetime, str, None]
Words = Union[str, Iterable[str], None]
Path = Union[str, "os.PathLike[str]"]

PAGE = 5_000
"""Detections of one answer."""
LAST_US = 9_007_199_254_740_991
"""The last time that the server takes, µs since 1970 UTC."""

# The columns of the table of detections that are no texts.
_DETECTIONS: Dict[str, str] = {
    **{name: "datetime" for name in ("heard_utc", "reported_utc", "received_utc")},
    **{
        name: "integer"
        for name in (
            "receiver", "snr [dB]", "sensor_value [count]", "frequency [kHz]", "tag_id", "lines_lost_before",
            "noise_average [count]", "noise_peak [count]", "memory_address",
        )
    },
    **{
        name: "number"
        for name in (
            "latitude [deg]", "longitude [deg]", "position_age [s]", "position_deviation [m]", "clock_count [s]",
            "noise_age [s]", "propeller_speed [rpm]", "sensor_reading", "min_lag [s]",
        )
    },
}

# Of the columns before the fields of a message, those that are no texts.
_SENDER: Dict[str, str] = {"time": "datetime", "unix_s": "number", "entity_id": "integer", "dst_ent": "integer"}


class Lutra:
    """A server, as a person with a token asks it.

    The token is made on the page *Account* or by `lutra-server token create`; without one here it is taken from the
    environment, `LUTRA_TOKEN`. Times are `datetime` (without a zone: UTC) or ISO 8601.
    """

    def __init__(self, url: str, token: Optional[str] = None, timeout_s: float = 60.0) -> None:
        token = token or os.environ.get("LUTRA_TOKEN")
        if not token:
            raise LutraError("give a token, or put it into the environment as LUTRA_TOKEN")
        self.connection = Connection(url, ("Authorization", f"Bearer {token}"), timeout_s)

    def vessels(self) -> List[Dict[str, Any]]:
        """The vessels that one may see, as they are now."""
        vessels: List[Dict[str, Any]] = self._json("/api/v1/vessels")
        return vessels

    def recorded(self) -> List[Dict[str, Any]]:
        """Which messages of which vessels are recorded, how many, and from when to when."""
        recorded: List[Dict[str, Any]] = self._json("/api/v1/recorded")
        return recorded

    def detections(
        self, start: Time = None, end: Time = None, vessel: Words = None, tag: Words = None,
        project: Words = None, area: Optional[str] = None, flags: bool = False,
    ) -> Iterator[Dict[str, Any]]:
        """What was heard, the oldest report first, page by page, as the API has it; with `flags` why to look twice."""
        query: Dict[str, Any] = {
            "from_us": _us(start, 0), "to_us": _us(end, LAST_US), "vessel": _words(vessel), "tag": _words(tag),
            "project": _each(project), "area": area, "flags": flags or None, "order": "oldest", "limit": PAGE,
        }
        while True:
            page = self._json("/api/v1/detections", query)
            yield from page["detections"]
            following = page["next"]
            if following is None:
                return
            query.update(following)

    def detection_rows(self, **question: Any) -> Iterator[Row]:
        """The table of detections with what the register knows of tags and animals, a dictionary for each row.

        Takes the question of `detections`, but no `flags`.
        """
        url = self.connection.url("/api/v1/detections.csv", _question(**question))
        return rows(self.connection.open(url, is_file=True), _DETECTIONS)

    def detection_frame(self, **question: Any) -> Any:
        """The same as a table of pandas, with its types. Needs pandas and pyarrow."""
        import io

        import pandas  # type: ignore[import-untyped]

        query = {**_question(**question), "format": "parquet"}
        return pandas.read_parquet(io.BytesIO(self.connection.read("/api/v1/detections.csv", query, is_file=True)))

    def download_detections(
        self, path: Path, format: str = "lutra", tries: int = 5, gzip: bool = False, **question: Any
    ) -> Downloaded:
        """Writes a file of detections in any format that the server knows. A download that was cut goes on."""
        query = {**_question(**question), "format": format, "gzip": gzip or None}
        return download(self.connection, self.connection.url("/api/v1/detections.csv", query), path, tries=tries)

    def rows(
        self, message: str, start: Time = None, end: Time = None, vessel: Words = None, entity: Words = None,
        field: Words = None, every_s: Optional[float] = None, angles: str = "rad",
    ) -> Iterator[Row]:
        """The rows of any message, such as `EstimatedState`, as they come: one in `every_s` seconds where that is given."""
        query = _table(message, start, end, vessel, entity, field, every_s, angles, units=False, guard=False)
        about = self._json("/api/v1/export.json", query)
        kinds = {column["name"]: column["type"] for column in about["columns"] if "type" in column}
        kinds.update(_SENDER)
        return rows(self.connection.open(self.connection.url("/api/v1/export.csv", query), is_file=True), kinds)

    def frame(
        self, message: Words, start: Time = None, end: Time = None, vessel: Words = None, entity: Words = None,
        field: Words = None, every_s: Optional[float] = None, angles: str = "rad",
    ) -> Any:
        """The rows of any message as a table of pandas, with its types. Needs pandas and pyarrow."""
        import io

        import pandas  # type: ignore[import-untyped]

        query = _table(message, start, end, vessel, entity, field, every_s, angles, units=False)
        return pandas.read_parquet(io.BytesIO(self.connection.read("/api/v1/export.parquet", query, is_file=True)))

    def download_rows(
        self, path: Path, message: Words, start: Time = None, end: Time = None, vessel: Words = None,
        entity: Words = None, field: Words = None, every_s: Optional[float] = None, angles: str = "rad",
        tries: int = 5, **more: Any,
    ) -> Downloaded:
        """Writes the table of one or more messages. The question is that of `rows`; `more` is what `GET /api/v1/export.csv` takes besides."""
        query = _table(message, start, end, vessel, entity, field, every_s, angles, **more)
        return download(self.connection, self.connection.url("/api/v1/export.csv", query), path, tries=tries)

    def datasets(self) -> List[Dict[str, Any]]:
        """The datasets that one may see."""
        datasets: List[Dict[str, Any]] = self._json("/api/v1/datasets")
        return datasets

    def download_dataset(
        self, path: Path, dataset: int, version: int, format: str = "lutra", verify: bool = True, tries: int = 5
    ) -> Downloaded:
        """Writes a published version. In the format `lutra` its SHA-256 is that of publication, or `VerifyError` is raised."""
        base = f"/api/v1/datasets/{dataset}/versions/{version}"
        sha256 = None
        if verify and format == "lutra":
            sha256 = published_sha256(self._json(f"{base}/datapackage.json"))
        url = self.connection.url(f"{base}/detections.csv", {"format": format})
        return download(self.connection, url, path, sha256, tries)

    def _json(self, path: str, query: Optional[Dict[str, Any]] = None) -> Any:
        return json.loads(self.connection.read(path, query))


class Link:
    """A shared link to a dataset: its address, and its password where it has one. A link for your account needs a token of
    yours, as an argument or in the environment, `LUTRA_TOKEN`."""

    def __init__(
        self, url: str, password: Optional[str] = None, timeout_s: float = 60.0, token: Optional[str] = None
    ) -> None:
        split = urllib.parse.urlsplit(url.strip())
        parts = split.path.strip("/").split("/")
        if len(parts) < 2 or parts[-2] != "s":
            raise LutraError("a link looks like https://…/s/ and 64 digits, or https://…/s/account- and a number")
        password = password or os.environ.get("LUTRA_LINK_PASSWORD")
        secret = ("Lutra-Link-Password", password) if password else None
        if parts[-1].startswith("account-"):
            token = token or os.environ.get("LUTRA_TOKEN")
            if not token:
                raise LutraError("this link is for an account: give a token of it, or put it into LUTRA_TOKEN")
            secret = ("Authorization", f"Bearer {token}")
        self.connection = Connection(f"{split.scheme}://{split.netloc}/{'/'.join(parts)}", secret, timeout_s)

    def about(self) -> Dict[str, Any]:
        """What the link gives: title, licence, columns, SHA-256 (a Frictionless package)."""
        package: Dict[str, Any] = json.loads(self.connection.read("/datapackage.json"))
        return package

    def rows(self) -> Iterator[Row]:
        """The rows of the dataset as they come."""
        return rows(self.connection.open(self.connection.url("/detections.csv"), is_file=True), _DETECTIONS)

    def download(self, path: Path, format: str = "lutra", verify: bool = True, tries: int = 5) -> Downloaded:
        """Writes the dataset. In the format `lutra` its SHA-256 is that of its description, or `VerifyError` is raised."""
        sha256 = published_sha256(self.about()) if verify and format == "lutra" else None
        url = self.connection.url("/detections.csv", {"format": format})
        return download(self.connection, url, path, sha256, tries)


def _question(
    start: Time = None, end: Time = None, vessel: Words = None, tag: Words = None, project: Words = None,
    area: Optional[str] = None,
) -> Dict[str, Any]:
    return {
        "from_us": None if start is None else _us(start, 0),
        "to_us": None if end is None else _us(end, LAST_US),
        "vessel": _words(vessel), "tag": _words(tag), "project": _each(project), "area": area,
    }


def _table(
    message: Words, start: Time, end: Time, vessel: Words, entity: Words, field: Words, every_s: Optional[float],
    angles: str, **more: Any,
) -> Dict[str, Any]:
    """The question for the table of messages."""
    return {
        "message": _words(message), "vessel": _words(vessel), "entity": _words(entity), "field": _words(field),
        "from": _iso(start), "to": _iso(end), "every_s": every_s, "angles": angles, **more,
    }


def _words(words: Words) -> Optional[str]:
    return words if words is None or isinstance(words, str) else ",".join(words)


def _each(words: Words) -> Optional[Each]:
    return None if words is None else Each([words] if isinstance(words, str) else words)


def _moment(when: Union[datetime, str]) -> datetime:
    if isinstance(when, str):
        # Python before 3.11 reads no Z.
        when = datetime.fromisoformat(when.strip().replace("Z", "+00:00"))
    return when if when.tzinfo else when.replace(tzinfo=timezone.utc)


def _us(when: Time, otherwise: int) -> int:
    if when is None:
        return otherwise
    span = _moment(when) - datetime(1970, 1, 1, tzinfo=timezone.utc)
    return (span.days * 86_400 + span.seconds) * 1_000_000 + span.microseconds


def _iso(when: Time) -> Optional[str]:
    return None if when is None else _moment(when).isoformat()
