"""What the chamber needs beside the package itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def chamber_extra() -> Iterator[None]:
    """Say what to install where an import finds that a package of the extra is missing.

    Raises
    ------
    ImportError
        A package of the extra ``chamber`` is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith("pinchoff"):
            raise
        raise ImportError(
            f"{error.name}, which the chamber needs, must be installed; got nothing; install it "
            "with: pip install 'pinchoff[chamber]'"
        ) from error
