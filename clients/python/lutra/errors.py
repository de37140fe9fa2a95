"""What can go wrong, and what to do about it."""

from __future__ import annotations

import json
from typing import Optional


class LutraError(Exception):
    """The server refused, or was not reached."""

    def __init__(self, text: str, status: Optional[int] = None, code: Optional[str] = None) -> None:
        super().__init__(text)
        self.status = status
        """The HTTP status; None where the server was not reached."""
        self.code = code
        """The server's code of the refusal, where it gave one."""


class CutError(LutraError):
    """A file was cut each time; what is there stays, and the next call goes on with it."""


class VerifyError(LutraError):
    """A file is whole, but has other bytes than were published."""


def refusal(status: int, body: bytes, where: str) -> LutraError:
    """The error in an answer: the server's own words, where it has some."""
    try:
        error = json.loads(body)["error"]
        return LutraError(f"{where}: {error['text']}", status, error.get("code"))
    except (ValueError, KeyError, TypeError):
        text = body[:200].decode("utf-8", "replace").strip()
        return LutraError(f"{where}: the server answered {status}: {text}", status)
