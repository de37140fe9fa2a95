"""Checks the package against a running server: `python3 against_server.py URL LINK PASSWORD DATASET ROWS`, with LUTRA_TOKEN and
LUTRA_ACCOUNT_LINK set.

Run by `server/tests/integration/clients.rs`, which starts the server with so many detections, a published dataset and a link with a password. A
relay in between cuts answers.
"""

from __future__ import annotations

import hashlib
import os
import socket
import sys
import tempfile
import threading
import urllib.parse
from datetime import datetime, timezone
from pathlib import Path
from typing import List, Optional, Tuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from lutra import client  # noqa: E402
from lutra import CutError, Link, Lutra, LutraError, VerifyError  # noqa: E402
from lutra.files import download  # noqa: E402


class Relay:
    """Passes requests on; of each answer so many bytes as `cuts` has next, then it hangs up. Without a number left: all."""

    def __init__(self, target: Tuple[str, int]) -> None:
        self.target, self.cuts, self.heads = target, [], []  # type: Tuple[str, int], List[int], List[str]
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        while True:
            client, _ = self.listener.accept()
            with client, socket.create_connection(self.target) as server:
                head = b""
                while b"\r\n\r\n" not in head:
                    head += client.recv(65536)
                self.heads.append(head.decode())
                server.sendall(head)
                left: Optional[int] = self.cuts.pop(0) if self.cuts else None
                while left is None or left > 0:
                    chunk = server.recv(4096 if left is None else min(left, 4096))
                    if not chunk:
                        break
                    client.sendall(chunk)
                    left = None if left is None else left - len(chunk)


def refused(what, *arguments, **named) -> LutraError:
    try:
        what(*arguments, **named)
    except LutraError as error:
        return error
    raise AssertionError(f"{what} was not refused")


def reading(lutra: Lutra, rows: int) -> None:
    assert any(one["system"] == 2068 and one["abbrev"] == "TBRFishTag" for one in lutra.recorded())
    assert isinstance(lutra.vessels(), list)
    found = list(lutra.detections())
    assert len(found) == rows, len(found)
    assert [one["time_us"] for one in found] == sorted(one["time_us"] for one in found)
    assert "flags" in next(lutra.detections(flags=True))
    before, client.PAGE = client.PAGE, 7
    assert [one["id"] for one in lutra.detections()] == [one["id"] for one in found], "pages of another size"
    client.PAGE = before
    table = list(lutra.detection_rows(tag=["S256-101"]))
    assert 0 < len(table) < rows
    first = table[0]
    assert first["tag"] == "S256-101" and first["snr [dB]"] == 20 and isinstance(first["latitude [deg]"], float)
    assert first["heard_utc"] == datetime(2024, 11, 21, 8, 0, 0, 7000, tzinfo=timezone.utc), first
    assert first["animal"] is None, "what is not known is None"
    part = list(lutra.detection_rows(start="2024-11-21T08:00:10Z", end=datetime(2024, 11, 21, 8, 0, 20)))
    assert len(part) == 10, len(part)
    states = list(lutra.rows("EstimatedState", vessel="0x0814", angles="deg"))
    assert len(states) == 3 and abs(states[0]["lat"] - 63.44) < 1e-9, states
    assert isinstance(states[0]["time"], datetime) and states[0]["unix_s"] > 1.7e9, states[0]
    with tempfile.TemporaryDirectory() as folder:
        start, end = "2024-11-21T08:00:01Z", datetime(2024, 11, 21, 8, 0, 2)
        found = lutra.download_rows(Path(folder) / "states.csv", "EstimatedState", start, end, vessel=["0x0814"], angles="deg")
        assert found.bytes > 0 and len(found.path.read_text().splitlines()) == 2, "a header and the second of three rows"
        every = lutra.download_rows(Path(folder) / "all.csv", ["EstimatedState", "TBRFishTag"], units=False)
        assert every.bytes > found.bytes, every


def refusals(url: str, link: str) -> None:
    wrong = refused(Lutra(url, token="0" * 64).vessels)
    assert wrong.status == 401, wrong
    unknown = refused(Lutra(url).rows, "EstimatedStat")
    assert unknown.status == 400 and "EstimatedState" in str(unknown), unknown
    guess = refused(Link(link, password="a wrong password").about)
    assert guess.status == 403 and link not in str(guess), guess
    assert refused(Link, "https://shore.example/datasets/1")
    secret = "0" * 60 + "beef"
    for wrong in (f"ftp://shore.example/s/{secret}", f"shore.example/s/{secret}", f"https://shore.example/a b/s/{secret}"):
        assert secret not in str(refused(Link, wrong)), wrong
    below = refused(Link(f"http://127.0.0.1:9/below/a/prefix/s/{secret}").about)
    assert secret not in str(below) and "/below/a/prefix/s/…/" in str(below), below
    with socket.create_server(("127.0.0.1", 0)) as silent:
        slow = refused(Lutra(f"http://127.0.0.1:{silent.getsockname()[1]}", timeout_s=0.2).vessels)
    assert slow.status is None and "did not answer within 0.2 s" in str(slow), slow
    away = refused(Lutra("http://127.0.0.1:9").vessels)
    assert away.status is None, away


def resuming(relay: Relay, url: str, folder: Path) -> None:
    whole = Lutra(url).download_detections(folder / "whole.csv")
    assert whole.resumed == 0 and whole.bytes > 50_000, whole
    lutra = Lutra(relay.url)
    lutra.connection.sleep = lambda _: None
    relay.cuts = [20_000, 20_000]
    found = lutra.download_detections(folder / "cut.csv")
    assert found.sha256 == whole.sha256 and found.resumed > 20_000, found
    assert "Range: bytes=" in relay.heads[-1] and "If-Range: " in relay.heads[-1], relay.heads[-1]
    # A later call goes on with what an earlier one left.
    relay.cuts = [30_000]
    cut = refused(lutra.download_detections, folder / "later.csv", tries=1)
    assert isinstance(cut, CutError) and (folder / "later.csv.part").exists() and not (folder / "later.csv").exists()
    found = lutra.download_detections(folder / "later.csv")
    assert found.sha256 == whole.sha256 and found.resumed > 10_000, found
    assert not list(folder.glob("*.part*")), list(folder.iterdir())
    # What is there of another question is not gone on with.
    relay.cuts = [30_000]
    refused(lutra.download_detections, folder / "other.csv", tries=1)
    other = lutra.download_detections(folder / "other.csv", tag="S256-101")
    assert other.resumed == 0 and other.bytes < whole.bytes, other
    # A table that is read as it comes says that it was cut.
    relay.cuts = [30_000]
    assert isinstance(refused(lambda: list(lutra.detection_rows())), CutError)
    for name in ("netcdf", "dwca", "geopackage", "parquet"):
        assert lutra.download_detections(folder / name, format=name).bytes > 500, name


def published(url: str, dataset: int, link: str, password: str, rows: int, folder: Path) -> None:
    lutra, shared = Lutra(url), Link(link, password)
    version = next(one for one in lutra.datasets() if one["id"] == dataset)["versions"][0]
    found = lutra.download_dataset(folder / "dataset.csv", dataset, 1)
    assert found.sha256 == version["content"]["sha256"], found
    assert hashlib.sha256((folder / "dataset.csv").read_bytes()).hexdigest() == found.sha256
    about = shared.about()
    assert about["title"] == "Salmon in the fjord" and about["resources"][0]["rows"] == rows, about
    by_link = shared.download(folder / "link.csv")
    assert by_link.sha256 == found.sha256
    assert len(list(shared.rows())) == rows
    target = folder / "wrong.csv"
    url = shared.connection.url("/detections.csv")
    wrong = refused(download, shared.connection, url, target, "0" * 64)
    assert isinstance(wrong, VerifyError) and not target.exists(), wrong


def main() -> None:
    url, link, password, dataset, rows = sys.argv[1:]
    split = urllib.parse.urlsplit(url)
    relay = Relay((split.hostname or "", split.port or 80))
    with tempfile.TemporaryDirectory() as folder:
        reading(Lutra(url), int(rows))
        refusals(url, link)
        resuming(relay, url, Path(folder))
        published(url, int(dataset), link, password, int(rows), Path(folder))
        assert sum(1 for _ in Link(os.environ["LUTRA_ACCOUNT_LINK"]).rows()) == int(rows)
    print("all as it should be")


if __name__ == "__main__":
    main()
