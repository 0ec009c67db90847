"""The statements of a program in an order in which few numbers wait to be used.

A kernel evaluates all devices, and then adds up what they carry: between the two, every current and slope
waits. A thread of a graphics processor has 127 registers for numbers, and what is too much goes through
memory. So in each stretch without branches a sum is taken as soon as what it waits for is there, as long as
little else has to be worked out for it. No sum changes: statements move, and what they compute is the same.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from typing import final

from circuits.programs.program import Program

_LITTLE = 40  # statements that may be worked out early for one that is taken; ours
_Place = tuple[str, int | None]  # a name, with the index where it is an element


def ordered(program: Program) -> Program:
    """The program with its statements in that order."""
    return program._replace(body=_block(program.body))


def _block(body: Sequence[ast.stmt]) -> list[ast.stmt]:
    found: list[ast.stmt] = []
    straight: list[ast.Assign] = []
    for s in body:
        if isinstance(s, ast.Assign) and all(index is not None for _, index in _places(s)):
            straight.append(s)
            continue
        found += _Stretch(straight).in_order()
        straight = []
        if isinstance(s, ast.If):
            s = ast.If(s.test, _block(s.body), _block(s.orelse))  # noqa: PLW2901 - the same, in order inside
        elif isinstance(s, ast.While):
            s = ast.While(s.test, _block(s.body), [])  # noqa: PLW2901
        found.append(s)
    return found + _Stretch(straight).in_order()


def _places(s: ast.AST) -> Iterator[_Place]:
    """What a statement, or an expression, reads or writes; None for an index that is not known."""
    for node in ast.iter_child_nodes(s):
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            at = node.slice.value if isinstance(node.slice, ast.Constant) else None
            yield node.value.id, at if isinstance(at, int) else None
        elif isinstance(node, ast.Name):
            yield node.id, -1
        else:
            yield from _places(node)


@final
class _Stretch:
    """Assignments without a branch between them."""

    def __init__(self, statements: Sequence[ast.Assign]) -> None:
        self._statements = statements
        self._needs: list[list[int]] = []
        self._takers: list[list[int]] = [[] for _ in statements]
        written: dict[_Place, int] = {}
        read: dict[_Place, list[int]] = {}
        for k, s in enumerate(statements):
            targets = list(_places(ast.Expr(s.targets[0])))
            sources = list(dict.fromkeys(_places(ast.Expr(s.value))))
            made = [written[place] for place in sources if place in written]
            for j in made:
                self._takers[j].append(k)
            before = [j for t in targets for j in read.get(t, ())]
            before += [written[t] for t in targets if t in written]
            self._needs.append(sorted({*made, *before}))
            for place in sources:
                read.setdefault(place, []).append(k)
            for t in targets:
                written[t], read[t] = k, []
        self._order: list[int] = []
        self._placed = [False] * len(statements)

    def in_order(self) -> list[ast.stmt]:
        """The statements, each behind what it needs."""
        for k in range(len(self._statements)):
            self._place(k)
        return [self._statements[k] for k in self._order]

    def _place(self, wanted: int) -> None:
        """Put a statement behind what it needs, and behind it what takes it and needs little else."""
        waiting = [wanted]
        while waiting:
            k = waiting.pop()
            for j in self._missing(k, len(self._statements)) or ():
                self._placed[j] = True
                self._order.append(j)
                waiting += [t for t in reversed(self._takers[j]) if self._adds(t)]
            waiting = [t for t in waiting if not self._placed[t] and self._missing(t, _LITTLE) is not None]

    def _adds(self, k: int) -> bool:
        """Whether a statement adds to a sum."""
        value = self._statements[k].value
        return isinstance(value, ast.BinOp) and isinstance(value.op, ast.Add | ast.Sub)

    def _missing(self, k: int, most: int) -> list[int] | None:
        """What a statement needs that is not placed, itself behind it; None where it is more than `most`."""
        found: list[int] = []
        seen: set[int] = set()
        stack = [(k, False)]
        while stack:
            j, below = stack.pop()
            if below:
                found.append(j)
            elif not self._placed[j] and j not in seen:
                seen.add(j)
                if len(seen) > most:
                    return None
                stack.append((j, True))
                stack += [(i, False) for i in reversed(self._needs[j])]
        return found
