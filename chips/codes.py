"""What a calibration found for a chip on a die: codes of its biases, what is off, and what was measured.

A calibration does what a laboratory can do with one chip on its bench: it sends events, counts spikes and
times them, and reads nodes that have a pad; it moves codes of the chip's bias generator, trims of its board,
and leaves out neurons or cells by their address. It never sees a deviation. What it found holds for that chip
on that silicon with that kind of biases, and is refused by any other, and where the law of transistors, units
or bias generator is no longer that by which it was found (`Codes.check`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from hashlib import sha256
from typing import Any

import numpy as np

from chips.law_lattice import key_changed, law_key
from chips.validity import OutsideBoxError
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.generator.code import codes_of, currents_of
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.units import format_quantity

Code = tuple[int, int]
"""Coarse and fine code of a line of the bias generator."""


@dataclass(frozen=True, slots=True)
class Measured:
    """What the bench measured of one thing, before and after.

    Attributes
    ----------
    name : str
        What it is, such as `best_delay[3]`.
    unit : str
        Unit of the three numbers, empty for plain numbers.
    wanted : float
        What the design wants.
    before, after : float
        What was measured at the usual codes and at those that were found; NaN where nothing could be.
    """

    name: str
    unit: str
    wanted: float
    before: float
    after: float


@dataclass(frozen=True, slots=True)
class Key:
    """The silicon and the kind of biases for which codes hold.

    Attributes
    ----------
    process, law : str
        Name of the process, and `ideal` or `full`.
    process_digest : str
        Hash of all numbers of the process, those of its mismatch too.
    die : str
        The die, as `A/1003` or `nominal`, with its corner and variation where they are not the usual ones.
    plan : str
        Hash of the sampling plan whose draws the die has, empty for its own.
    bias_kind : str
        What stands behind the bias currents.
    setup : str
        Hash of what the chip is set up for, empty where it is always the same.
    """

    process: str
    law: str
    process_digest: str
    die: str
    plan: str
    bias_kind: BiasKind
    setup: str


def key_of(silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Key:
    """Return the key of a silicon, whose temperature does not count, a kind of biases, and a setup."""
    process, die = silicon.process, silicon.die
    plan = "" if die.sampling is None else _digest(die.sampling)
    made_for = "" if setup is None else _digest(setup)
    name = str(die).removeprefix("die ")
    return Key(process.name, process.effects, _digest(process), name, plan, kind, made_for)


def _digest(value: object) -> str:
    return sha256(repr(value).encode()).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class Codes:
    """What a calibration found for a chip on a die.

    Attributes
    ----------
    chip : str
        Name of the calibration, which is that of its chip or of the network on it.
    key : Key
        What the codes hold for.
    calibrated_c : float
        Temperature of the bench, degC.
    biases : mapping
        Coarse and fine codes of biases by name, one for each element of an array of lines.
    off : mapping
        Numbers of what is left out by its address, by the name of its array.
    trims : mapping
        Values of trims of the board by name, in SI units.
    measured : tuple of Measured
        What the bench measured.
    bench_s : float
        Time that the chip was run on the bench, s.
    unmended : tuple of str
        What stays off, a sentence each.
    failed : str
        Why the chip cannot be used at all; empty where it can.
    law : mapping
        Key of the law by which it was found (`chips.law_lattice.law_key`), numbers by family.
    """

    chip: str
    key: Key
    calibrated_c: float
    biases: Mapping[str, tuple[Code, ...]] = field(default_factory=dict)
    off: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    trims: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    measured: tuple[Measured, ...] = ()
    bench_s: float = 0.0
    unmended: tuple[str, ...] = ()
    failed: str = ""
    law: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def current(self, name: str) -> float | tuple[float, ...]:
        """Return the nominal current of a bias at 27 degC, A: one number, or one an element."""
        found = currents_of(np.array(self.biases[name]))
        return float(found[0]) if found.size == 1 else tuple(map(float, found))

    @property
    def currents(self) -> dict[str, float | tuple[float, ...]]:
        """Nominal currents of all its biases at 27 degC, A, as `circuits.bias.rebias` takes them."""
        return {name: self.current(name) for name in self.biases}

    def check(self, chip: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> None:
        """Ask that the codes are of a chip on a silicon, set up as it is, and that the chip can be used.

        Raises
        ------
        ParameterError
            They are of another chip, die, process, law or kind of biases, or the calibration failed, or the
            law of the process has changed since.
        """
        if self.chip != chip:
            raise ParameterError(f"codes: of {self.chip}, must be of {chip}; calibrate that")
        wanted = key_of(silicon, kind, setup)
        for name in (f.name for f in fields(Key)):
            own, other = getattr(self.key, name), getattr(wanted, name)
            if own != other:
                raise ParameterError(
                    f"codes of {chip}: {name} {own or 'none'}, the run has {other or 'none'}; calibrate the"
                    " chip on that silicon"
                )
        other = key_changed(self.law, silicon.process)
        if other:
            raise ParameterError(f"codes of {chip}: of {other}; calibrate the chip on that silicon again")
        self.require_usable()

    def require_usable(self) -> None:
        """Raise `ParameterError`, which says why, for a chip that could not be calibrated."""
        if self.failed:
            raise ParameterError(
                f"{self.chip}: die {self.key.die} could not be calibrated, {self.failed}; take another die,"
                " or default codes"
            )


def _anywhere(_: Silicon) -> None:
    """A model that holds at every temperature."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """How a chip is calibrated.

    Attributes
    ----------
    name, summary
        Its name on the command line, and a line of what is measured and moved.
    process : Process
        Process of the chip, with all its second-order effects.
    calibrate
        Calibrates the chip on a silicon, at the silicon's temperature, with biases of a kind, for a setup. It
        is a function of a module, in whose folder all sources are that its codes follow from beside those of
        circuits and chips.
    setup
        What the chip is set up for unless a run says otherwise, such as the design of its network.
    require_temperature
        Raises `ParameterError`, as `chips.validity` says, for a silicon at whose temperature the chip's model
        does not hold; it costs nothing, so that a run asks it before it calibrates for seconds.
    """

    name: str
    summary: str
    process: Process
    calibrate: Callable[[Silicon, BiasKind, Any], Codes]
    setup: Hashable = None
    require_temperature: Callable[[Silicon], None] = _anywhere


def codes_begun(name: str, silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """Return codes of which name, key, temperature and today's law stand; arguments as of `attempted`."""
    key, law = key_of(silicon, kind, setup), law_key(silicon.process)
    return Codes(name, key, silicon.temperature_c, law=law)


def attempted(
    name: str, silicon: Silicon, kind: BiasKind, setup: Hashable, find: Callable[[Codes], Codes]
) -> Codes:
    """Return what a calibration finds on a silicon, at its temperature.

    A chip that it cannot bring to its design has failed: a line has no code for what it should have, or a
    neuron never spikes. A value outside of a model's box (`chips.validity`) is no fault of the chip.

    Parameters
    ----------
    name
        Of the calibration.
    silicon
        What is calibrated, at the temperature of the bench.
    kind, setup
        Kind of the chip's biases, and what it is set up for.
    find
        Fills in codes as `codes_begun` makes them; it raises `ParameterError`, whose text is the reason,
        where it cannot.

    Raises
    ------
    OutsideBoxError
        Of `find`, as it is.
    """
    made = codes_begun(name, silicon, kind, setup)
    try:
        return find(made)
    except OutsideBoxError:
        raise
    except ParameterError as error:
        return replace(made, failed=str(error))


def codes_near(currents: Mapping[str, object]) -> dict[str, tuple[Code, ...]]:
    """Return the codes nearest to currents (A), one number or an array a bias, as `Codes.biases` has them.

    Raises `ParameterError` for a current that no code reaches.
    """
    found: dict[str, tuple[Code, ...]] = {}
    for name, value in currents.items():
        codes = codes_of(np.ravel(np.asarray(value, np.float64)))
        found[name] = tuple((int(c), int(f)) for c, f in codes)
    return found


def left_off(measured: Iterable[Measured], share: float) -> tuple[str, ...]:
    """Return a sentence of each thing that ended farther off than a share of what it should be."""
    told = []
    for each in measured:
        if not math.isfinite(each.after):
            told.append(f"{each.name}: nothing could be measured")
        elif abs(each.after - each.wanted) > share * abs(each.wanted):
            off = 100.0 * (each.after / each.wanted - 1.0)
            values = (format_quantity(v, each.unit) for v in (each.after, each.wanted))
            told.append("{}: {} for {} ({:+.3g} %)".format(each.name, *values, off))
    return tuple(told)
