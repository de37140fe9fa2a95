"""Requests: headers, errors, and waiting where a server is busy."""

from __future__ import annotations

import http.client
import re
import socket
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

from .errors import LutraError, refusal

BUSY = (429, 503)
"""Statuses after which the same question may be asked again."""
LONGEST_WAIT_S = 60.0
"""A server that asks for a longer wait is not waited for."""
CONNECT_S = 30.0
"""How long a connection may take to begin."""
FILE_S = 900.0
"""How long the server may be silent about a file, at least: some formats are known whole only at their end."""

Query = Mapping[str, Any]


class Each(Tuple[str, ...]):
    """Values of a parameter that is given once for each of them: they may have commas."""


class _Stay(urllib.request.HTTPRedirectHandler):
    """Follows no redirection: it could take the secret elsewhere."""

    def redirect_request(self, *_: Any, **__: Any) -> None:
        return None


def _connect(connection: http.client.HTTPConnection, connect: Callable[[], None]) -> None:
    """Connects within a time of its own, which is shorter than that of an answer."""
    patience_s = connection.timeout
    connection.timeout = min(CONNECT_S, patience_s) if isinstance(patience_s, (int, float)) else CONNECT_S
    try:
        connect()
    finally:
        connection.timeout = patience_s
    connection.sock.settimeout(patience_s)


class _Plain(http.client.HTTPConnection):
    def connect(self) -> None:
        _connect(self, super().connect)


class _Secure(http.client.HTTPSConnection):
    def connect(self) -> None:
        _connect(self, super().connect)


class _Http(urllib.request.HTTPHandler):
    def http_open(self, request: urllib.request.Request) -> Any:
        return self.do_open(_Plain, request)


class _Https(urllib.request.HTTPSHandler):
    def https_open(self, request: urllib.request.Request) -> Any:
        return self.do_open(_Secure, request)


_OPENER = urllib.request.build_opener(_Stay, _Http, _Https)


class Connection:
    """Where questions go, and the header that says who asks."""

    def __init__(
        self,
        base: str,
        secret: Optional[Tuple[str, str]],
        timeout_s: float,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        # The address of a link is a secret: no error shows it.
        scheme = urllib.parse.urlsplit(base).scheme
        if scheme not in ("http", "https"):
            raise LutraError("an address begins with https:// (or http:// in one's own network)")
        if re.search(r"[\x00-\x20\x7f]", base):
            raise LutraError("the address has a space or a line break in it")
        self.base = base.rstrip("/")
        self._headers: Dict[str, str] = {"User-Agent": "lutra-python/0.1"}
        if secret:
            self._headers[secret[0]] = secret[1]
        self._timeout_s = timeout_s
        self.sleep = sleep

    def url(self, path: str, query: Optional[Query] = None) -> str:
        """The address of a path; what is None in a query is left out, a list becomes words between commas."""
        said = [
            (name, _word(one)) for name, value in (query or {}).items() if value is not None
            for one in (value if isinstance(value, Each) else (value,))
        ]
        return f"{self.base}{path}" + (f"?{urllib.parse.urlencode(said)}" if said else "")

    def open(
        self, url: str, headers: Optional[Mapping[str, str]] = None, tries: int = 4, is_file: bool = False
    ) -> http.client.HTTPResponse:
        """An answer whose body is not read yet. A busy server is asked again as it wishes, so many times in all. A file may take the server
        minutes to prepare."""
        timeout_s = max(self._timeout_s, FILE_S) if is_file else self._timeout_s
        for attempt in range(1, tries + 1):
            request = urllib.request.Request(url, headers={**self._headers, **(headers or {})})
            try:
                answer: http.client.HTTPResponse = _OPENER.open(request, timeout=timeout_s)
                return answer
            except urllib.error.HTTPError as error:
                if error.code == 416:
                    return error  # type: ignore[return-value]
                with error:
                    wait_s = _wait_s(error.headers.get("Retry-After"))
                    if error.code not in BUSY or attempt == tries or wait_s > LONGEST_WAIT_S:
                        raise refusal(error.code, error.read(65536), _place(url)) from None
            except socket.timeout as error:
                text = f"the server did not answer within {timeout_s:g} s; it may still be preparing the file"
                raise LutraError(f"{_place(url)}: {text}") from error
            except (urllib.error.URLError, OSError, http.client.HTTPException) as error:
                raise LutraError(f"{_place(url)}: the server was not reached: {error}") from error
            self.sleep(wait_s)
        raise AssertionError("the last attempt returns or raises")

    def read(self, path: str, query: Optional[Query] = None, is_file: bool = False) -> bytes:
        """The whole body of an answer."""
        url = self.url(path, query)
        try:
            with self.open(url, is_file=is_file) as answer:
                return answer.read()
        except (http.client.HTTPException, OSError) as error:
            raise LutraError(f"{_place(url)}: the answer was cut: {error}") from error


def _place(url: str) -> str:
    """An address without its query; that of a link is a secret and is not shown."""
    return re.sub(r"/s/[^/]+", "/s/…", urllib.parse.urlsplit(url).path)


def _wait_s(text: Optional[str]) -> float:
    try:
        return max(0.5, float(text or ""))
    except ValueError:
        return 2.0


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, set, frozenset)):
        return ",".join(_word(one) for one in value)
    return str(value)
