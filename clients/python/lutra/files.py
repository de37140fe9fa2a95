"""Downloads that go on where they broke off, and files that are what was published.

A file grows as `NAME.part`, with `NAME.part.json` beside it, which says of which state of the data it is. It gets its name once it is whole and
its SHA-256, where one is known, is right. A download that was cut goes on, in this call or in a later one, as long as the server still gives the
same bytes; else it starts from the beginning.
"""

from __future__ import annotations

import hashlib
import http.client
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Optional, Union

from .errors import CutError, LutraError, VerifyError
from .http import Connection

CHUNK = 1 << 16


@dataclass(frozen=True)
class Downloaded:
    """A file that is whole."""

    path: Path
    bytes: int
    sha256: str
    resumed: int
    """How many bytes were there already when the last request was made."""


def download(
    connection: Connection,
    url: str,
    path: Union[str, "os.PathLike[str]"],
    sha256: Optional[str] = None,
    tries: int = 5,
) -> Downloaded:
    """Fetches a file. `sha256` is what its bytes must have; `tries` is how often a cut download goes on before `CutError`."""
    target = Path(path)
    part, note = Path(f"{target}.part"), Path(f"{target}.part.json")
    for attempt in range(1, tries + 1):
        begun = _begun(part, note, url)
        try:
            _fetch(connection, url, part, note, begun)
            break
        except (http.client.HTTPException, OSError, LutraError) as error:
            if isinstance(error, LutraError) and (error.status is not None or begun is None):
                raise
            if attempt == tries:
                size = part.stat().st_size if part.exists() else 0
                text = f"{target}: cut {tries} times, {size} bytes are there; call it again to go on: {error}"
                raise CutError(text) from error
            connection.sleep(min(2.0 ** (attempt - 1), 30.0))
    resumed = begun[0] if begun else 0
    found = _sha256(part)
    if sha256 is not None and found != sha256.lower():
        part.unlink()
        note.unlink(missing_ok=True)
        text = (
            f"{target}: these are not the bytes that were published (SHA-256 {found}, not {sha256}): the archive has changed since, "
            "or another version of Lutra writes them. The file was removed; without verify it is kept"
        )
        raise VerifyError(text)
    size = part.stat().st_size
    os.replace(part, target)
    note.unlink(missing_ok=True)
    return Downloaded(target, size, found, resumed)


def _begun(part: Path, note: Path, url: str) -> Optional["tuple[int, str]"]:
    """How much is there of this file, and of which state; None where nothing fits."""
    try:
        said = json.loads(note.read_text(encoding="utf-8"))
        size = part.stat().st_size
    except (OSError, ValueError):
        return None
    # The address of a link is a secret: what is kept of an address is its hash.
    if said.get("url_sha256") != _of_url(url) or not said.get("etag") or size == 0:
        return None
    return size, said["etag"]


def _fetch(connection: Connection, url: str, part: Path, note: Path, begun: Optional["tuple[int, str]"]) -> None:
    headers: Dict[str, str] = {"Accept-Encoding": "identity"}
    if begun:
        headers.update({"Range": f"bytes={begun[0]}-", "If-Range": begun[1]})
    with connection.open(url, headers, is_file=True) as answer:
        if answer.status == 416:
            # All of it is there, or the file is shorter now.
            total = (answer.headers.get("Content-Range") or "").rpartition("/")[2]
            if begun and total == str(begun[0]) and answer.headers.get("ETag") == begun[1]:
                return
            part.unlink(missing_ok=True)
            raise http.client.HTTPException("the file is another one now")
        goes_on = begun is not None and answer.status == 206
        if not goes_on:
            _write_note(note, url, answer.headers.get("ETag"))
        # By read1, for read forgets what it has of a chunk that is cut.
        received = 0
        with open(part, "ab" if goes_on else "wb") as out:
            while chunk := answer.read1(CHUNK):
                received += len(chunk)
                out.write(chunk)
        # Where the length was said before, http.client takes a cut body for a whole one.
        expected = answer.headers.get("Content-Length")
        if expected is not None and received < int(expected):
            raise http.client.IncompleteRead(b"", int(expected) - received)


def _write_note(note: Path, url: str, etag: Optional[str]) -> None:
    # A weak tag promises no bytes.
    strong = etag if etag and not etag.startswith("W/") else None
    note.write_text(json.dumps({"url_sha256": _of_url(url), "etag": strong}), encoding="utf-8")


def _of_url(url: str) -> str:
    return hashlib.sha256(url.encode()).hexdigest()


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while chunk := file.read(CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def published_sha256(package: Dict[str, object]) -> str:
    """The SHA-256 that a `datapackage.json` has of its one table."""
    try:
        said = str(package["resources"][0]["hash"])  # type: ignore[index]
    except (KeyError, IndexError, TypeError):
        said = ""
    if not said.startswith("sha256:"):
        raise LutraError("the description of the dataset names no SHA-256")
    return said[len("sha256:"):]
