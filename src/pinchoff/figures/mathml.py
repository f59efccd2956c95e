"""Formulas of pages as MathML, which every browser of today typesets by itself.

They are written as they would be in plain text: ``Bk = (Ca Ã z̃)(S/α)^(-1/β)``. A power, an index
or a fraction takes what stands next to it, a letter, a number or a group in parentheses; the
parentheses of an exponent, of an index and of the parts of a fraction are not shown.
"""

from __future__ import annotations

import re
from html import escape
from typing import NamedTuple

_TOKEN = re.compile(
    r"\s+|\d+(?:\.\d+)?|[^\W\d_][\u0300-\u036f]?[^\W\d_]*[0-9]*|[-−+=<>≤≥≈∝,;:·×√|∞%^_/()]"
)
_OPERATORS = {"-": "−"}
_THIN = '<mspace width="0.17em"></mspace>'
_CLOSER = {"/": "^_", "^": "_"}  # what binds more closely


class _Piece(NamedTuple):
    """A part of a formula, and the same without its outer parentheses."""

    shown: str
    bare: str


def formula(text: str, *, display: bool = False) -> str:
    """Return a formula as MathML.

    Parameters
    ----------
    text : str
    display : bool, optional
        Whether it stands on a line of its own.

    Raises
    ------
    ValueError
        It holds a sign that has no meaning here, or a parenthesis without its partner.

    Examples
    --------
    >>> formula("x^(1/w)")
    '<math><msup><mi>x</mi><mrow><mn>1</mn><mo>/</mo><mi>w</mi></mrow></msup></math>'
    """
    tokens = _tokens(text)
    pieces = _row(tokens)
    if tokens:
        raise ValueError(f"a parenthesis in {text!r} has no partner")
    kind = ' display="block"' if display else ""
    return f"<math{kind}>{_joined(pieces)}</math>"


def _tokens(text: str) -> list[str]:
    """Return the tokens of a formula, the first one last."""
    tokens, place = [], 0
    while place < len(text):
        found = _TOKEN.match(text, place)
        if found is None:
            raise ValueError(f"{text[place]!r} has no meaning in a formula")
        place = found.end()
        if found[0].strip():
            tokens.append(found[0])
    return tokens[::-1]


def _row(tokens: list[str], small: bool = False) -> list[_Piece]:
    """Return pieces up to a closing parenthesis, which stays in the tokens, or to the end.

    In small print, such as that of an exponent, a fraction stays on one line.
    """
    pieces: list[_Piece] = []
    while tokens and tokens[-1] != ")":
        if tokens[-1] in ("^", "_") or (tokens[-1] == "/" and not small):
            sign = tokens.pop()
            if not pieces or not tokens:
                raise ValueError(f"{sign!r} stands between two parts of a formula")
            before, after = pieces.pop(), _piece(tokens, small or sign != "/")
            pieces.append(_combined(sign, before, after, tokens))
        else:
            pieces.append(_piece(tokens, small))
    return pieces


def _combined(sign: str, before: _Piece, after: _Piece, tokens: list[str]) -> _Piece:
    while tokens and tokens[-1] in _CLOSER.get(sign, ()):
        after = _combined(tokens.pop(), after, _piece(tokens, True), tokens)
    if sign == "/":
        made = f"<mfrac>{before.bare}{after.bare}</mfrac>"
    else:
        kind = "msup" if sign == "^" else "msub"
        made = f"<{kind}>{before.shown}{after.bare}</{kind}>"
    return _Piece(made, made)


def _piece(tokens: list[str], small: bool) -> _Piece:
    """Take one letter, number, operator or group."""
    token = tokens.pop()
    if token == "(":
        inside = _joined(_row(tokens, small))
        if not tokens:
            raise ValueError("a parenthesis has no partner")
        tokens.pop()
        stretch = "" if "<mfrac>" in inside else ' stretchy="false"'
        left, right = (f"<mo{stretch}>{sign}</mo>" for sign in "()")
        return _Piece(f"<mrow>{left}{inside}{right}</mrow>", f"<mrow>{inside}</mrow>")
    if token[0].isdigit():
        made = f"<mn>{token}</mn>"
    elif token[0].isalpha():
        made = f"<mi>{escape(token)}</mi>"
    else:
        made = f"<mo>{escape(_OPERATORS.get(token, token))}</mo>"
    return _Piece(made, made)


def _joined(pieces: list[_Piece]) -> str:
    """Return the pieces in a row, with a thin space between factors."""
    shown = [piece.shown for piece in pieces]
    for k in range(len(shown) - 1, 0, -1):
        if not any(part.startswith("<mo>") for part in shown[k - 1 : k + 1]):
            shown.insert(k, _THIN)
    return "".join(shown)
