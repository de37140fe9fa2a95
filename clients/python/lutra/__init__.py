"""Detections, messages and datasets of a Lutra server, for scripts and notebooks.

`Lutra` speaks with a server as a person, by a token; `Link` opens a shared link. Both need the standard library only.
"""

from .client import Link, Lutra
from .errors import CutError, LutraError, VerifyError
from .files import Downloaded

__all__ = ["CutError", "Downloaded", "Link", "Lutra", "LutraError", "VerifyError"]
__version__ = "0.1.0"
