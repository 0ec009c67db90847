"""The bench: a teaching chip on its board, with the verbs that somebody who has done the laboratory knows.

    bench = CoachBench(die=Die(number=7))
    bench.select("NDP")
    bench.set_bias("NDP_VB_N", "N", 30e-9, 50)
    bench.set_voltage("AIN5", 0.95)
    bench.set_voltage("AIN6", 0.85)
    bench.read_counts("C2F0", 0.1), bench.read_counts("C2F1", 0.1)

Every reading solves the circuit's transistors with the biases of the lines and the voltages as the DAC makes
them, from where the reading before has left it: a circuit with hysteresis stays on its branch. What is read
comes as the board reads it, with its steps, dead zones and counts; the chip's own current or voltage is
`exact`.

    bench = CoachBench(Silicon(process_of("coach-180"), die=read_die_file("die.toml")), identified="die.toml")

is the bench of a chip that `noctule identify` found: its masters, codes, converters, ammeters and offsets.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from chips.coach.generator import Code, Generator, Kind, line_share, line_voltage
from chips.coach.identified import Found, found_of, identified_silicon, read_identified
from chips.coach.readout import (
    FAST_STEP,
    RANGES,
    Board,
    Channel,
    channel,
    counted_current,
    interference,
    read_ammeter,
    read_counts,
    read_level,
    set_level,
)
from chips.coach.wiring import CIRCUITS, Wiring
from circuits.arrays import F64
from circuits.blocks.drive import Wave, current_into, driven
from circuits.checks import require_choice
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.devices.source import PiecewiseLinear, polyline
from circuits.errors import ParameterError, SolverError, unknown_name
from circuits.event import pulse
from circuits.extraction.coach.posterior import ConverterRow
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.on_die import transistor_of
from circuits.measure.current import static_currents
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.power import drain_current
from circuits.solver.sweep.continuation import with_source
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

_EDGE = 1e-6  # s, of a voltage that is set within a record
_LONGEST = 1_000_000  # samples of a record


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """What a record leaves.

    Attributes
    ----------
    time
        When each sample was taken, float64[samples], s.
    values
        Readings by pin, float64[samples]: V of outputs, counts of converters since the sample before.
    """

    time: F64
    values: Mapping[str, F64]


@final
class CoachBench:
    """A teaching chip on its board, as a laboratory has it.

    Parameters
    ----------
    silicon
        Process, temperature and die; the nominal 0.18 um process at 27 degC unless given.
    board
        Errors of what sets and reads.
    generator
        Errors of the bias generator beside its devices'.
    seed
        Keys what differs from one reading to the next.
    identified
        File of the die that `noctule identify` wrote, of which numbers of the process, board and generator
        are taken in the place of nominal ones; `found` then says which. Its die must be the silicon's, and
        the process the one that it was identified on.

    Raises
    ------
    DataError
        The file of an identified die cannot be read, or is of another die or process.
    ParameterError
        A board or generator is given beside the identified ones.
    """

    def __init__(
        self,
        silicon: Silicon | None = None,
        board: Board | None = None,
        generator: Generator | None = None,
        seed: int = 0,
        identified: Path | str | None = None,
    ) -> None:
        self.silicon = silicon or Silicon(ROLLS_180)
        self.board, self.generator, self.seed = board or Board(), generator or Generator(), seed
        self.found: Found | None = None
        self._identified = None if identified is None else read_identified(Path(identified))
        if self._identified is not None:
            if board is not None or generator is not None:
                raise ParameterError(f"identified: {identified}, states board and generator; leave them out")
            self.silicon = identified_silicon(self._identified, self.silicon)
        self._biases: dict[str, Code] = {}
        self._levels: dict[str, float] = {}
        self._span, self._readings = "low", 0
        self._machine: Machine | None = None
        self._point: OperatingPoint | None = None
        self.select("NDP")

    def select(self, circuit: str) -> None:
        """Let the multiplexers choose a circuit, whose pins begin at 0 V; biases stay as they were set.

        `circuit` is its name, as NDP. Raises `UnknownNameError` for a circuit that the chip does not have.
        """
        if circuit not in CIRCUITS:
            raise unknown_name("circuit of coach", circuit, CIRCUITS)
        self.circuit = circuit
        self._levels = dict.fromkeys(self.wiring.inputs, 0.0)
        self._machine = self._point = None
        if self._identified is not None:
            self.found = found_of(self._identified, circuit)
            self.generator = self.found.generator
            self.board = self._calibrated(self.found, self._identified.temperature_c)

    @property
    def wiring(self) -> Wiring:
        """Pins and biases of the circuit that is chosen."""
        return CIRCUITS[self.circuit]

    def set_bias(self, name: str, kind: Kind, master: float, fine: int) -> None:
        """Set a bias by its name.

        Parameters
        ----------
        name
            As `NDP_VB_N`.
        kind
            Type of its output device, `N` or `P`.
        master
            The coarse current, A.
        fine
            The fine code, 0 to 255.

        Raises
        ------
        UnknownNameError
            The chosen circuit has no such bias.
        ParameterError
            The generator has no such type, master or code.
        """
        self._known("bias", name, self.wiring.lines)
        try:
            self._biases[name] = Code(kind, master, fine)
        except ParameterError as error:
            raise ParameterError(f"{name}: {error}") from None

    def set_voltage(self, pin: str, volt: float) -> float:
        """Set a pin to a voltage, and return what the DAC makes of it, V.

        `pin` is its name, as AIN5; `volt` in V. Raises `UnknownNameError` for a pin that the chosen circuit
        does not have, and `ParameterError` for a voltage that leaves the supply.
        """
        self._known("pin", pin, self.wiring.inputs)
        self._levels[pin] = set_level(self.board, pin, volt, self.silicon.process.v_dd)
        return self._levels[pin]

    def set_range(self, span: str) -> None:
        """Choose the range of the transistors' ammeters.

        `span` is low, to 1 uA, or high, to 100 uA. Raises `ParameterError` for another.
        """
        require_choice("range", span, tuple(RANGES))
        self._span = span
        self._machine = self._point = None

    def _calibrated(self, found: Found, celsius: float) -> Board:
        """The board with the charges of what converters truly took when they were calibrated."""
        at = replace(self.silicon, temperature_c=celsius)
        scaled = {}
        for pin, row in found.calibrated.items():
            one = found.board.channels[pin]
            probe = CoachBench(at, generator=found.generator)
            share = probe._calibration(self.circuit, pin, row, found)
            scaled[pin] = replace(one, charge=one.charge * share)
        return replace(found.board, channels={**found.board.channels, **scaled})

    def _calibration(self, circuit: str, pin: str, row: ConverterRow, found: Found) -> float:
        """What a pin's transistor carries at a calibration, over the current that is nominal there."""
        self.select(circuit)
        self.found = found
        code = Code("P" if row.bias.endswith("_P") else "N", row.master, row.fine)
        self._biases[row.bias] = code
        self._levels |= dict(zip(self.wiring.inputs, row.voltages, strict=True))
        nominal = row.w * row.master * line_share(self.generator, row.bias, code, self.silicon)
        return self.exact(pin, self.wiring.counted) / nominal

    def read_voltage(self, pin: str) -> float:
        """What the ADC reads at a pin, V.

        `pin` is its name, as ADC13. Raises `UnknownNameError` for a pin that the chosen circuit does not
        have, and `SolverError` where the circuit comes to no rest.
        """
        return float(read_level(self.board, self.exact(pin, self.wiring.outputs)))

    def read_current(self, pin: str) -> float:
        """What the ammeter at a pin of a transistor reads, A.

        `pin` is its name, as GO22. Raises as `read_voltage`.
        """
        return read_ammeter(self.board, self.exact(pin, self.wiring.ammeters), self.board.ranges[self._span])

    def read_counts(self, pin: str, time: float = 0.1) -> int:
        """Number of events that a converter counts, a word of 16 bits.

        `pin` is the channel's name, as C2F0; `time` in s. Raises as `read_voltage`, and `ParameterError` for
        no time.
        """
        current = self.exact(pin, self.wiring.counted)
        return read_counts(self.board, self._converter(pin), current, time, self._normal(pin))

    def _converter(self, pin: str) -> Channel:
        return self.board.channels.get(pin) or channel(_number(pin))

    def current_of(self, pin: str, counts: float, time: float = 0.1) -> float:
        """Current that so many counts of a converter mean by its nominal charge and dead time, A.

        `pin` is the channel's name, as C2F0; `counts` are those of `time`, in s. Dark counts are taken away,
        and one event is the least. Raises `ParameterError` for another channel.
        """
        return counted_current(self.board, channel(_number(pin)), counts, time)

    def exact(self, pin: str, among: Mapping[str, str] | None = None) -> float:
        """What stands at a pin, without the board: V of an output, A of what an ammeter or a converter gets.

        `pin` is its name, `among` the nodes or devices by pin that it is looked for in, all of the chosen
        circuit unless given. Raises as `read_voltage`.
        """
        wiring = self.wiring
        known = {**wiring.outputs, **wiring.ammeters, **wiring.counted} if among is None else among
        self._known("pin", pin, known)
        point = self.settle()
        if known[pin] in point.machine.names:
            return point[known[pin]]
        return abs(float(static_currents(point.machine, point.voltage[None])[known[pin]][0]))

    def settle(self) -> OperatingPoint:
        """Let the circuit come to rest near where it was; raises `SolverError` where it does not."""
        machine = self._with_levels()
        found = None if self._point is None else solve_near(machine, self._point.voltage)
        if found is None or not found.stable:
            found = operating_point(machine)
        if not found.stable:
            raise SolverError(
                f"coach.{self.circuit}: comes to no rest with these biases; record a waveform instead"
            )
        self._point = found
        return found

    def record(
        self,
        pins: Sequence[str],
        samples: int,
        interval: float,
        *,
        steps: Mapping[str, float] | None = None,
        events: Sequence[float] = (),
        fast: bool = False,
    ) -> Record:
        """Record outputs and counts of converters over time.

        Parameters
        ----------
        pins
            What is recorded.
        samples
            How many samples.
        interval
            Time between them, s.
        steps
            Voltages (V) by pin that are set between the first sample and the second.
        events
            Times at which an event comes in, s.
        fast
            Whether the ADC has ten bits and the board's interference, as quick records have.

        Raises
        ------
        UnknownNameError
            A pin that the chosen circuit does not have.
        ParameterError
            No samples or too many, no time between them, or events where none can come in.
        """
        self._check_record(pins, samples, interval, events)
        time: F64 = interval * np.arange(samples, dtype=np.float64)
        result = simulate(
            self._recorded(float(time[-1]) + interval, interval, steps or {}, events), self.silicon
        )
        values = {}
        for pin in pins:
            if pin in self.wiring.outputs:
                v = np.interp(time, result.time, result[self.wiring.outputs[pin]])
                noise = interference(self.board, time, 0.5 + 0.1 * self._normal(pin)) if fast else 0.0
                values[pin] = read_level(self.board, v + noise, *((FAST_STEP,) if fast else ()))
            else:
                current = np.abs(drain_current(result, self.wiring.counted[pin]))
                values[pin] = self._counts(pin, result.time, current, time, interval)
        for pin, volt in (steps or {}).items():
            self.set_voltage(pin, volt)
        return Record(time, values)

    def _counts(self, pin: str, at: F64, current: F64, time: F64, interval: float) -> F64:
        """Counts in the interval behind each sample."""
        charge = np.concatenate([[0.0], np.cumsum(0.5 * (current[1:] + current[:-1]) * np.diff(at))])
        mean = np.diff(np.interp(np.append(time, time[-1] + interval), at, charge)) / interval
        one = self._converter(pin)
        found = [read_counts(self.board, one, float(i), interval, self._normal(pin)) for i in mean]
        return np.array(found, dtype=np.float64)

    def _check_record(
        self, pins: Sequence[str], samples: int, interval: float, events: Sequence[float]
    ) -> None:
        for pin in pins:
            self._known("pin", pin, {**self.wiring.outputs, **self.wiring.counted})
        if not 2 <= samples <= _LONGEST:
            raise ParameterError(f"record: {samples} samples, must be 2 to {_LONGEST}")
        if not interval > 0.0:
            raise ParameterError(f"record: {interval:g} s between samples, must be > 0")
        if events and not self.wiring.events:
            raise ParameterError(f"coach.{self.circuit}: no events come in here; leave `events` out")

    def _recorded(
        self, stop: float, interval: float, steps: Mapping[str, float], events: Sequence[float]
    ) -> Testbench:
        """The testbench of a record, in which voltages are set half an interval behind the first sample."""
        bench = self._testbench(stop)
        block = self.wiring.block.bench()
        waves: dict[str, Wave] = {}
        for pin, volt in steps.items():
            self._known("pin", pin, self.wiring.inputs)
            level = set_level(self.board, pin, volt, self.silicon.process.v_dd)
            at = 0.5 * interval
            before = self._levels[pin]
            wave = PiecewiseLinear((0.0, at, at + min(_EDGE, 0.1 * interval)), (before, before, level))
            waves[self.wiring.inputs[pin]] = wave
        if events:
            waves[self.wiring.events] = pulse(tuple(events), self.silicon.process.v_dd)
        moved = {source.node: source for source in driven(waves)}
        sources = tuple(moved.get(s.node, s) if s.quantity == "voltage" else s for s in bench.sources)
        return replace(bench, sources=sources, initial=block.initial)

    def _with_levels(self) -> Machine:
        """The circuit's machine, with every source at the present voltage."""
        bench = self._testbench(1.0)
        if self._machine is None:
            self._machine = to_kernel(bench, self.silicon)
        machine = self._machine
        for source in bench.sources:
            position = machine.source_names.index(source.name)
            value = float(polyline(source.name, source.waveform)[1][0])
            if machine.polylines[position][1][0] != value:
                machine = with_source(machine, position, value)
        self._machine = machine
        return machine

    def _testbench(self, stop: float) -> Testbench:
        """The chosen circuit with its pins and biases as they stand."""
        wiring, v_dd = self.wiring, self.silicon.process.v_dd
        circuit = self._built()
        ports = {port.name for port in circuit.ports}
        levels = {port: self._levels[pin] for pin, port in wiring.inputs.items()}
        levels |= dict(wiring.held)
        levels |= {wiring.events: 0.0} if wiring.events else {}
        levels |= {port: self._line(name, circuit) for name, port in wiring.lines.items()}
        levels |= {"vdd": v_dd} if "vdd" in ports else {}
        own = {} if self.found is None else self.found.current
        currents = (current_into(node, i) for node, i in {**wiring.current, **own}.items())
        return Testbench(f"coach.{self.circuit}", circuit, (*driven(levels), *currents), stop)

    def _built(self) -> Circuit:
        """The chosen circuit, a transistor's between the shunts of the chosen range."""
        block = self.wiring.block
        sizes = block.sizes if self.found is None else replace(block.sizes, **self.found.sizes)
        if self.wiring.ammeters:
            shunt = self.board.ranges[self._span].shunt
            sizes = replace(sizes, drain_resistance=shunt, source_resistance=shunt)
        return block.build(sizes)

    def _line(self, name: str, circuit: Circuit) -> float:
        """Voltage of a bias line, V; of one that was never set, that of its rail."""
        code = self._biases.get(name)
        if code is None:
            return self.silicon.process.v_dd if name.endswith("_P") else 0.0
        biased = _biased(circuit, self.wiring.lines[name])
        return line_voltage(self.generator, name, code, self.silicon, biased)

    def _known(self, what: str, name: str, known: Mapping[str, str]) -> None:
        if name not in known:
            raise unknown_name(f"{what} of coach.{self.circuit}", name, known)

    def _normal(self, pin: str) -> float:
        """A standard normal of this reading, which hangs on the seed, the die, the pin and its number."""
        self._readings += 1
        die = self.silicon.die
        text = f"{self.seed}/{die.lot}/{die.number}/{pin}/{self._readings}"
        key = int.from_bytes(hashlib.blake2b(text.encode(), digest_size=16, person=b"coach-reading").digest())
        return float(np.random.Generator(np.random.Philox(key=key)).standard_normal())


def _biased(circuit: Circuit, port: str) -> Transistor | None:
    """The transistor that a port biases; None where it is a voltage of several."""
    device = next((b.device for b in circuit.biases if b.port == port), None)
    return transistor_of(circuit, device) if device else None


def _number(pin: str) -> int:
    """Number of the channel that a converter's pin names."""
    return int("".join(c for c in pin.partition("_")[0].removeprefix("C2F") if c.isdigit()))
