"""What the tests of several commands share."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable

import pytest

from pinchoff.cli import main

_FORM = re.compile(
    r"error: (?P<argument>.+?) must be (?P<rule>.+?); got (?P<got>.+?); (?P<advice>.+)\n"
)


@pytest.fixture
def refusal(capsys: pytest.CaptureFixture[str]) -> Callable[..., dict[str, str]]:
    """Function (*words) -> the parts of a command's refusal, which is one line of our form."""

    def call(*words: object) -> dict[str, str]:
        assert main([*map(str, words)]) == 2
        printed = capsys.readouterr()
        form = _FORM.fullmatch(printed.err)
        assert form is not None, printed.err
        assert printed.out == ""
        return form.groupdict()

    return call


@pytest.fixture(scope="session")
def program() -> list[str]:
    """The program in a process of its own, for what signals and pipes do to it."""
    return [sys.executable, "-c", "import sys; from pinchoff.cli import main; sys.exit(main())"]
