"""Immutable, checked models whose refusals are `InputError` and name the key."""

from __future__ import annotations

import difflib
import inspect
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from pinchoff.support.arguments import number_rule
from pinchoff.support.errors import InputError


def unknown_name(argument: str, rule: str, got: object, known: Iterable[str]) -> InputError:
    """Make the error for a name that does not exist, suggesting the nearest one that does."""
    names = sorted(known)
    near = difflib.get_close_matches(str(got), names, n=1)
    advice = f"did you mean '{near[0]}'?" if near else f"choose from {', '.join(names)}"
    return InputError.of(argument, rule, repr(got), advice)


def _not_boolean(value: object) -> object:
    if isinstance(value, bool):
        raise ValueError
    return value


Number = Annotated[float, BeforeValidator(_not_boolean), Field(allow_inf_nan=False)]
WholeNumber = Annotated[int, BeforeValidator(_not_boolean)]


@dataclass(frozen=True)
class Explanation:
    """What the message of a refused value says; pydantic holds it for us beside the field.

    Attributes
    ----------
    rule : str
        Completes "<name> must be".
    meaning : str
        What the value is; completes "give".
    note : str
        What else the documentation says of it.
    """

    rule: str
    meaning: str
    note: str

    @property
    def advice(self) -> str:
        """What to give in place of a refused value."""
        return f"give {self.meaning}"

    def __call__(self, schema: dict[str, Any]) -> None:
        """Add to the JSON schema, as pydantic asks of what stands in this place: nothing."""


def explained(rule: str, meaning: str, *, note: str = "", **options: Any) -> Any:
    """Return a pydantic field, with its `Explanation`; options are those of `pydantic.Field`."""
    entry = Explanation(rule, meaning, note)
    return Field(description=meaning, json_schema_extra=entry, **options)


def number(low: float, high: float, meaning: str, **options: Any) -> Any:
    """Return a pydantic field for a number in [low, high]."""
    return explained(number_rule(low, high), meaning, ge=low, le=high, **options)


_DOCSTRING_WIDTH = 92


def with_parameters(docstring: str | None, parameters: Mapping[str, str]) -> str | None:
    """Return a docstring with parameters, ``name : type`` and text, in place of ``**values``."""
    if docstring is None:  # python -OO
        return None
    lines = docstring.splitlines()
    place = lines.index("    **values")
    indent = " " * 8
    written = []
    for name, text in parameters.items():
        text = f"{text[0].upper()}{text[1:]}"
        wrapped = textwrap.wrap(
            text, _DOCSTRING_WIDTH, initial_indent=indent, subsequent_indent=indent
        )
        written += [f"    {name}", *wrapped]
    return "\n".join([*lines[:place], *written, *lines[place + 2 :]])


_PYDANTICS = {*dir(BaseModel)}


class Checked(BaseModel):
    """Immutable model; None stands for the default of a value.

    Raises
    ------
    InputError
        A value is refused, a name is unknown, or something is missing.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Let help and completion show names and defaults, not pydantic's types."""
        cls.__signature__ = inspect.Signature(
            [
                inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=_shown(field))
                for name, field in cls.model_fields.items()
            ]
        )

    def __dir__(self) -> list[str]:
        """Return what is ours: values, properties and methods, without pydantic's."""
        own = {*type(self).model_fields, "replace"}
        return sorted(own | {name for name in super().__dir__() if name not in _PYDANTICS})

    if not TYPE_CHECKING:  # type checkers take the keywords from the fields

        def __init__(self, **values: Any) -> None:
            given = {name: value for name, value in values.items() if value is not None}
            try:
                super().__init__(**given)
            except ValidationError as error:
                raise _refusal(type(self), error) from None

        def __setattr__(self, name: str, value: object) -> None:
            raise InputError.of(name, "left as it was made", value, f"use replace({name}=...)")

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some values changed, checked anew.

        A value that was never given keeps following its default, also where that depends on
        another value. None goes back to the default.

        Raises
        ------
        InputError
            As the constructor.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**{**given, **changes})

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Check a mapping of values, as the constructor does."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise _refusal(cls, error) from None

    def __str__(self) -> str:
        return repr(self)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy as `replace` does: a copy is checked like the original."""
        return self.replace(**(update or {}))


_PARAMETERS = """

    Parameters
    ----------
    **values
        Each as its entry says.
    """


class Documented(Checked):
    """A model whose docstring lists its parameters as their entries in the class body say."""

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Write the entries in place of ``**values``, or behind the docstring."""
        super().__pydantic_init_subclass__(**options)
        text = cls.__doc__
        if text is not None and "**values" not in text:
            text += _PARAMETERS
        entries = dict(map(_described, cls.model_fields.items()))
        cls.__doc__ = with_parameters(text, entries)


def _described(parameter: tuple[str, FieldInfo]) -> tuple[str, str]:
    name, field = parameter
    entry = field.json_schema_extra
    assert isinstance(entry, Explanation)
    kinds: dict[Any, str] = {float: "float", int: "int", bool: "bool"}
    default = "" if field.is_required() else f", by default {field.default}"
    text = f"{entry.meaning}: {entry.rule}{default}. {entry.note}".rstrip()
    return f"{name} : {kinds.get(field.annotation, 'str')}", text


def _shown(field: FieldInfo) -> Any:
    """Return the default that a signature shows: None where it follows from other values."""
    if field.is_required():
        return inspect.Parameter.empty
    return None if field.default_factory else field.default


def _refusal(model: type[BaseModel], error: ValidationError) -> InputError:
    """Turn the first of pydantic's findings into an error of our form."""
    finding = error.errors(include_url=False)[0]
    name = str(finding["loc"][0]) if finding["loc"] else ""
    cause = finding.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause.within(name) if name else cause
    if not finding["loc"]:
        advice = "give it as keywords"
        return InputError.of(model.__name__, "a table of values", finding["input"], advice)
    field = model.model_fields.get(name)
    if field is None:
        return unknown_name(name, "the name of a parameter", name, model.model_fields)
    explanation = field.json_schema_extra
    assert isinstance(explanation, Explanation)
    got = "nothing" if finding["type"] == "missing" else repr(finding["input"])
    return InputError.of(name, explanation.rule, got, explanation.advice)
