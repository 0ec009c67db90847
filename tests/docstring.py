"""What a docstring says of each parameter, result and error, and what is missing in it."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from tests.house import PACKAGES

# A unit stands behind a comma, a bracket, a number or a word such as "in", and is no word by itself.
_UNITS = (
    r"1/s|1/V|1/m|A|C|F|F/m|GHz|Hz|J|K|MHz|Ohm|Pa|S|V|V m|V/K|V/s|W|dB|deg|degC|degrees|eV|fF|kHz|kOhm|lux|m|"
    r"mV|mm|ms|nA|nm|ohm|pA|pF|pixels|rad|rad/s|s|uA|um|us|m/s|m\^2|V\^2|V\^2/Hz|A\^2/Hz|A/V\^2|F/m\^2|A/m"
)
_UNIT = re.compile(rf"(?:^|[\s(\[,/*])(?:{_UNITS})(?=$|[\s.,;:)\]*^/])")
_ARTICLE = re.compile(r"(?:^|\s)A (?=[a-z])")
_PLAIN = re.compile(
    r"\b(?:dimensionless|shares?|counts?|counted|numbers? of|number|relative|ratio|factor|fractions?|percent|"
    r"probabilit\w+|units?|SI|decades?|octaves?|times as|codes?|levels?|logarithms?|"
    r"from -?\d[\d.]* to -?\d[\d.]*|0 to 1|standard normals?|samples|index|indices|steps|p value|multiples?|"
    r"weights?|NaN)\b|%",
    re.IGNORECASE,
)
_SHAPE = re.compile(r"\w*\[[^\]]*\]|\bshapes?\b|\bbroadcast|one for each|one each")
_NUMBERS = re.compile(r"\b(?:float|F64|F32|C128)\b")
_ARRAY = re.compile(r"\b(?:F64|F32|C128|I64|I32|I8|U64|Bools|NDArray|ArrayLike)\b")
_SECTION = re.compile(
    r"^(Parameters|Attributes|Returns|Yields|Raises|Notes|References|See Also)\n-{4,}$", re.MULTILINE
)


def missing(name: str, thing: object) -> list[str]:
    """Everything that the documentation of a public thing does not say, a line each."""
    if isinstance(thing, type):
        return list(_missing_of_class(name, thing))
    if callable(thing):
        return list(_missing_of_function(name, thing))
    return []


def said_of(doc: str, name: str) -> str:
    """All that a docstring says of a parameter or field: its entry, or the sentences that name it.

    An entry is `name` or `name : type` with its text indented below, or `name: text`, also for several names
    with commas between them; elsewhere a name stands in backticks.
    """
    found = [_indented(doc, name), *_inline(doc, name)]
    sentences = re.split(r"(?<=[.;:])\s+|\n\n", doc)
    found += [each for each in sentences if f"`{name}`" in each]
    return "\n".join(filter(None, found))


def has_unit(text: str) -> bool:
    """Whether a text tells a unit, or says that there is none."""
    return bool(_PLAIN.search(text) or _UNIT.search(_ARTICLE.sub(" ", text)))


def has_shape(text: str) -> bool:
    """Whether a text tells an array's shape."""
    return bool(_SHAPE.search(text))


def result_text(doc: str) -> str:
    """What a docstring says of the result: its section, or else everything but the parameters and errors."""
    parts = _SECTION.split(doc)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    return sections.get("Returns") or sections.get("Yields") or parts[0]


def raised(function: Callable[..., Any]) -> set[str]:
    """Names of the errors that the body of a function raises itself, not those of functions inside it."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError):
        return set()
    body = tree.body[0]
    if not isinstance(body, ast.FunctionDef):
        return set()
    return {
        error
        for node in _own(body)
        if isinstance(node, ast.Raise) and node.exc is not None
        if (error := _error(node.exc, function.__globals__))
    }


def _missing_of_class(name: str, cls: type) -> Iterator[str]:
    doc = inspect.cleandoc(vars(cls).get("__doc__") or "")
    if not doc or doc.startswith(f"{cls.__name__}("):
        yield f"{name}: no docstring"
        return
    if issubclass(cls, Exception):
        return
    for part, annotation in _parts(cls).items():
        said = said_of(doc, part) or _word(doc, part, annotation) or _said_of_base(cls, part)
        yield from _missing_of_value(f"{name}.{part}", said, annotation)
    for method in ("__init__", "__post_init__"):
        if inspect.isfunction(own := vars(cls).get(method)):
            yield from (f"{name}: raises {e}, not told" for e in sorted(raised(own)) if e not in doc)
    for each in reversed(cls.__mro__):
        if each.__module__.partition(".")[0] in PACKAGES:
            yield from _missing_of_methods(name, each)


def _missing_of_methods(name: str, cls: type) -> Iterator[str]:
    for key, member in vars(cls).items():
        if key.startswith("_"):
            continue
        function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
        if inspect.isfunction(function):
            yield from _missing_of_function(f"{name}.{key}", function)


def _missing_of_function(name: str, given: Any) -> Iterator[str]:
    function = inspect.unwrap(getattr(given, "py_func", given))
    function = getattr(function, "__func__", function)
    doc = inspect.getdoc(given) or ""
    if not doc:
        yield f"{name}: no docstring"
        return
    signature = inspect.signature(function)
    for parameter in signature.parameters.values():
        if parameter.name not in {"self", "cls"} and not parameter.name.startswith("_"):
            annotation = str(parameter.annotation)
            said = said_of(doc, parameter.name) or _word(doc, parameter.name, annotation)
            yield from _missing_of_value(f"{name}({parameter.name})", said, annotation)
    yield from _missing_of_text(f"{name} -> result", result_text(doc), str(signature.return_annotation))
    yield from (f"{name}: raises {error}, not told" for error in sorted(raised(function)) if error not in doc)


def _missing_of_value(name: str, said: str, annotation: str) -> Iterator[str]:
    if not said:
        yield f"{name}: not told"
    else:
        yield from _missing_of_text(name, said, annotation)


def _missing_of_text(name: str, said: str, annotation: str) -> Iterator[str]:
    if _NUMBERS.search(annotation) and not has_unit(said):
        yield f"{name}: no unit"
    if _ARRAY.search(annotation) and not has_shape(said):
        yield f"{name}: no shape"


def _parts(cls: type) -> dict[str, str]:
    """Public fields of a class, or the parameters of its constructor, with the text of their annotations."""
    if is_dataclass(cls):
        return {f.name: str(f.type) for f in fields(cls) if not f.name.startswith("_")}
    if hasattr(cls, "_fields"):
        return {key: str(value) for key, value in cls.__annotations__.items()}
    own = {k: str(v) for k, v in vars(cls).get("__annotations__", {}).items() if not k.startswith("_")}
    if inspect.isfunction(init := vars(cls).get("__init__")) and not getattr(cls, "_is_protocol", False):
        own |= {
            p.name: str(p.annotation) for p in inspect.signature(init).parameters.values() if p.name != "self"
        }
    return own


def _word(doc: str, name: str, annotation: str) -> str:
    """The whole docstring where a part that is one of our own classes is named in it as a plain word."""
    plain = re.fullmatch(r"'?[A-Z]\w+(?:\[[^\]]*\])?(?: \| None)?'?", annotation)
    own = plain and not _NUMBERS.search(annotation) and not _ARRAY.search(annotation)
    words = name.replace("_", " ")
    return doc if own and re.search(rf"\b{words}\b", doc, re.IGNORECASE) else ""


def _said_of_base(cls: type, part: str) -> str:
    """What the docstring of a base class says of a field that it brings."""
    bases = [each for each in cls.__mro__[1:] if part in vars(each).get("__annotations__", {})]
    return said_of(inspect.cleandoc(bases[-1].__doc__ or ""), part) if bases else ""


def _indented(doc: str, name: str) -> str:
    """Entry whose text is indented below its name."""
    lines = doc.split("\n")
    for at, line in enumerate(lines[:-1]):
        head = re.match(r"(\s*)([\w*, ]+?)(?: : .*)?$", line)
        if head is None or name not in re.split(r"[\s,*]+", head[2]):
            continue
        depth = len(head[1])
        block = []
        for below in lines[at + 1 :]:
            if below.strip() and len(below) - len(below.lstrip()) <= depth:
                break
            block.append(below)
        if block and block[0].strip():
            return "\n".join([line, *block])
    return ""


def _inline(doc: str, name: str) -> Iterator[str]:
    """Entries of the form `name: text`, each up to the next one or the end of its paragraph."""
    begin = r"(?:^|(?<=[.;] )|(?<=\n))[\w`]+(?:(?:,| and) [\w`]+)* ?: "
    for paragraph in doc.split("\n\n"):
        text = re.sub(r"\n\s*", "\n", paragraph)
        starts = [found.start() for found in re.finditer(begin, text)]
        for start, end in zip(starts, [*starts, len(text)][1:], strict=True):
            names = re.split(r"[\s,`]+", text[start:end].partition(":")[0])
            if name in names:
                yield text[start:end]


def _own(function: ast.FunctionDef) -> Iterator[ast.AST]:
    """Nodes of a function's body without those of functions inside it."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, ast.FunctionDef | ast.Lambda | ast.ClassDef):
            waiting += ast.iter_child_nodes(node)


def _error(raised_value: ast.expr, names: dict[str, Any]) -> str:
    """Name of the error's class: as it stands, or that which a function of ours returns."""
    called = raised_value.func if isinstance(raised_value, ast.Call) else raised_value
    if not isinstance(called, ast.Name):
        return ""
    made = names.get(called.id, getattr(__builtins__, called.id, None))
    if isinstance(made, type):
        return made.__name__ if issubclass(made, Exception) else ""
    returned = getattr(made, "__annotations__", {}).get("return", "")
    return str(returned) if str(returned).endswith("Error") else ""
