"""A chip has the deviations of its devices from `on_die`, and the law from `circuits.devices`."""

import ast
import re
from pathlib import Path

import chips

MODULES = sorted(Path(chips.__file__).parent.rglob("*.py"))
DRAWS = {"deviation", "deviations", "standard_normals", "mismatch"}
# ln(1 + e^x), its square or its inverse, by any of numpy's or math's functions
LAW = re.compile(
    r"logaddexp\(0(\.0)?,|log1p\((np|math)\.exp\(|log\((np|math)\.expm1\(|log\(-(np|math)\.expm1\(-q"
)
CUT = Path("rolls/cut.py")  # hands a plan of draws to the transistor level, where no model is
LATTICE = Path("law_lattice.py")  # evaluates the law of draws itself, for records to be held against it


def draws(text: str) -> list[str]:
    """Names of draws of mismatch that a module calls or imports."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            found += [node.func.attr] if node.func.attr in DRAWS - {"mismatch"} else []
        elif isinstance(node, ast.ImportFrom) and (node.module or "").endswith("silicon.die"):
            found += [alias.name for alias in node.names if alias.name in DRAWS]
    return found


def areas(text: str) -> list[int]:
    """Lines in which a width is multiplied by a length."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
            names = {n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute)}
            found += [node.lineno] if {"width", "length"} <= names else []
    return found


def test_no_chip_draws_adds_up_areas_or_spells_the_law() -> None:
    root = MODULES[0].parent
    found = {}
    for path in MODULES:
        text = path.read_text(encoding="utf-8")
        named = [] if path.relative_to(root) in (CUT, LATTICE) else draws(text)
        found[str(path.relative_to(root))] = [*named, *areas(text), *(m.group() for m in LAW.finditer(text))]
    assert {name: hits for name, hits in found.items() if hits} == {}


def test_what_is_looked_for_is_found() -> None:
    assert draws("from circuits.silicon.die import mismatch\nsilicon.deviation('x', (), 1.0)\n")
    assert areas("area = d.width * d.length\n")
    assert LAW.search("np.logaddexp(0.0, x)")
    assert LAW.search("np.log1p(np.exp(x))")
    assert LAW.search("math.log(math.expm1(q))")
    assert LAW.search("q + np.log(-np.expm1(-q))")
