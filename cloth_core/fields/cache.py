"""Distance fields kept on disk, so that each is built once on a machine."""

from __future__ import annotations

import hashlib
import os
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from cloth_core.fields.field import Field, Pool
from cloth_core.kernels import sources_digest

FORMAT = 1
"""Of the files; one of another format is built again."""

FOLDER_VARIABLE = "CLOTH_CORE_FIELDS"
"""Environment variable that moves the folder; empty: nothing is kept."""


def default_folder() -> Path | None:
    """Where fields are kept unless a caller says otherwise: ``cloth_core/fields`` in the user's cache folder."""
    given = os.environ.get(FOLDER_VARIABLE)
    if given is not None:
        return Path(given) if given else None
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(home) / "cloth_core" / "fields"


def digest(arrays: Iterable[np.ndarray], *settings: object) -> str:
    """Of all that a field depends on: arrays and settings given, this format, and the sources that sample it."""
    total = hashlib.sha256(f"{FORMAT} {sources_digest()} {settings!r}".encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        total.update(source.read_bytes())
    _add(total, arrays)
    return total.hexdigest()[:32]


def kept(name: str, build: Callable[[], Field], folder: Path | None) -> Field:
    """The field that is kept under ``name``, or that ``build`` makes, which is then kept.

    A file that is damaged or holds something else is built anew; a folder that cannot be written keeps nothing.
    """
    if folder is None:
        return build()
    path = Path(folder) / f"{name}.npz"
    field = _read(path, name)
    if field is None:
        field = build()
        _write(path, name, field)
    return field


def _read(path: Path, name: str) -> Field | None:
    """The field of a file, or None if it does not hold the one of that name, whole."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            pool = Pool(*(file[key] for key in Pool._fields))
            intact = str(file["name"]) == name and str(file["sum"]) == _sum(pool)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, NotImplementedError, zlib.error):
        return None
    return Field(pool) if intact else None


def _write(path: Path, name: str, field: Field) -> None:
    """All at once: whoever reads meanwhile, or after a crash, finds the whole file or none."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            try:
                np.savez_compressed(file, **field.pool._asdict(), name=np.array(name), sum=np.array(_sum(field.pool)))
                file.close()
                os.replace(file.name, path)
            except BaseException:
                os.unlink(file.name)
                raise
    except OSError:  # it is built again next time
        return


def _sum(pool: Pool) -> str:
    total = hashlib.sha256()
    _add(total, pool)
    return total.hexdigest()


def _add(total: hashlib._Hash, arrays: Iterable[np.ndarray]) -> None:
    for array in arrays:
        total.update(f"{array.dtype} {array.shape} ".encode())
        total.update(np.ascontiguousarray(array).tobytes())
