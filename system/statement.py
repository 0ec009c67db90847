"""Statements of an experiment: the paper's value, ours, and the rule by which they agree."""

from __future__ import annotations

from dataclasses import dataclass

from system.rule import Judged, Rule, Value, shown_of


@dataclass(frozen=True, slots=True)
class Statement:
    """One row of a report. Sentence, tolerance and verdict are the rule's, so that they cannot differ.

    `paper` and `ours` are in the unit that `name` ends with (`best_delay_s`), or words; None where the paper
    gives none or the run has none. `fitted`: the value was used to choose parameters, so that its agreement
    proves nothing.
    """

    name: str
    paper: Value
    ours: Judged
    rule: Rule
    fitted: bool = False

    @property
    def shown(self) -> Value:
        """Our value as a report gives it, a number or words."""
        return shown_of(self.ours)

    @property
    def agrees(self) -> bool | None:
        """Whether the rule holds; None where it gives no verdict."""
        return self.rule.holds(self.ours, self.paper)

    def row(self) -> dict[str, Value | bool]:
        """The statement as a row of a JSON document."""
        return {
            "name": self.name,
            "paper": self.paper,
            "ours": self.shown,
            "rule": self.rule.text,
            "tolerance": self.rule.tolerance,
            "fitted": self.fitted,
            "agrees": self.agrees,
        }
