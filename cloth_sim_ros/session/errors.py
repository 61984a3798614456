"""The one error that session files raise."""

from __future__ import annotations

from pathlib import Path


class SessionError(Exception):
    """A session cannot be written or read; the message names the path and the reason."""

    @classmethod
    def from_os(cls, path: Path, what: str, error: OSError) -> SessionError:
        """``path``: what failed and the operating system's reason for it."""
        return cls(f"{path}: {what}: {error.strerror or error}")
