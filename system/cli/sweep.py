"""The verb `noctule sweep`: operating points or measures over sources, silicon and options of a block."""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.catalogue import loaded
from circuits.circuit import GROUND
from circuits.errors import ParameterError, unknown_name
from circuits.measure.branch import element_of
from circuits.measure.unit import value_text
from circuits.sweep.line import Solve, solve_line
from circuits.sweep.sweep import Plan, run_points, run_transients
from netlists.read.analysis import TEMPERATURE, Stepped
from netlists.read.text.name import circuit_name
from system.cli.block_choice import choose_block, steps_of
from system.cli.deadline import deadline_of
from system.cli.deck_measures import own_measures, own_turned
from system.cli.exit_status import DONE, NO
from system.cli.option_names import option_of
from system.cli.output import plain, print_json, print_line, print_table, progress_bar, working
from system.cli.sweep_picture import draw_sweep
from system.cli.sweep_verb import Sweep
from system.files.writing import check_folder, write_netcdf_atomic, write_text_atomic
from system.notice import say
from system.options.begin import FREE
from system.options.begun import read_voltages
from system.options.block import Choice, describe_silicon, silicon_line
from system.options.swept import Options, Swept, build_of, read_swept
from system.plot import check_picture, save_picture

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = 24  # rows that are printed; CSV and JSON have all
_NODES = 4  # that are printed and drawn unless some are named


@dataclass(frozen=True, slots=True)
class _Found:
    """A sweep that was made: its dataset, and which of its nodes and currents are printed and drawn."""

    asked: Sweep
    choice: Choice
    swept: tuple[Swept, ...]
    data: xr.Dataset
    nodes: tuple[str, ...]
    currents: tuple[str, ...]

    @property
    def points(self) -> bool:
        """Whether operating points were asked for, with measures of their curves or without."""
        return self.asked.analysis == "dc"


def sweep_command(asked: Sweep) -> int:
    """Sweep a block, print what was found, and write the files that are asked for.

    Returns the exit status, `NO` where no point has a solution.
    """
    asked = _with_own(asked)
    _check(asked)
    choice = _choose(asked, {})
    swept = read_swept(choice, asked.over)
    plan = _plan(asked, choice, swept)
    if asked.analysis == "dc":
        with working(f"sweeping {asked.block}"):
            data = run_points(plan, asked.measure)
    else:
        with progress_bar(f"sweeping {asked.block}") as progress:
            data = run_transients(plan, asked.measure, progress)
    found = _Found(asked, choice, swept, data, *_shown(asked, choice, data))
    if asked.csv is not None:
        write_text_atomic(asked.csv, _csv(found))
    if asked.netcdf is not None:
        write_netcdf_atomic(asked.netcdf, _for_netcdf(data))
    title = f"{asked.block}, {_place(choice, swept)}".replace("degC", "°C")
    if asked.plot is not None and not (found.nodes or found.currents or _drawn(data)):
        raise ParameterError("--plot: nothing to draw; name a node by --node")
    save_picture(asked.plot, partial(draw_sweep, data, found.nodes, found.currents, title))
    if asked.as_json:
        print_json(_document(found))
    else:
        _print(found)
    return _status(found)


def _with_own(asked: Sweep) -> Sweep:
    """What is asked for, with a deck's own steps where none are, and its own measures of transients."""
    own: tuple[str, ...] = ()
    over = asked.over or tuple(map(_over, steps_of(asked.block)))
    if asked.analysis == "tran":
        choice = _choose(asked, {})
        moved = [each.name for each in read_swept(choice, over) if each.kind == "param"]
        own = own_measures(asked.block, asked.silicon, lambda: choice, moved)
    return replace(asked, over=over, measure=(*own, *asked.measure))


def _over(step: Stepped) -> str:
    """A step of a deck as an option has it."""
    if step.is_parameter:
        return f"param:{step.name}={','.join(f'{value!r}' for value in step.values)}"
    if step.name == TEMPERATURE:
        return f"temperature={','.join(f'{value!r}degC' for value in step.values)}"
    unit = "V" if step.name[0] == "v" else "A"
    return f"source:{circuit_name(step.name)}={','.join(f'{value!r}{unit}' for value in step.values)}"


def _check(asked: Sweep) -> None:
    if not asked.over:
        raise ParameterError("--over: nothing to sweep, must be at least one; write --over v_in=0V..5V:101")
    if asked.analysis == "tran":
        for name in ("node", "current", "start"):
            if getattr(asked, name):
                raise ParameterError(f"{option_of(name)}: not of --analysis tran; leave it out")
        if asked.engine != "native":
            raise ParameterError("--engine: ngspice, not of --analysis tran; take native")
    elif asked.begin != FREE:
        raise ParameterError("--ic, --uic, --at-rest: of transients; leave them out, or give --start")
    check_picture(asked.plot)
    for path in (asked.csv, asked.netcdf):
        if path is not None:
            check_folder(path)


def _choose(asked: Sweep, over: Options) -> Choice:
    """The block with options over those that were asked for."""
    given = asked.values
    values = replace(
        given, param=(*given.param, *over.get("param", ())), bias=(*given.bias, *over.get("bias", ()))
    )
    stimuli = (*asked.stimulus, *over.get("stimulus", ()))
    return choose_block(asked.block, values, asked.silicon, stimuli, asked.begin, steps="left")


def _plan(asked: Sweep, choice: Choice, swept: Sequence[Swept]) -> Plan:
    build, units = build_of(partial(_choose, asked), swept)
    deadline_s = deadline_of(asked.deadline, asked.engine)
    solve: Solve = solve_line
    if asked.engine == "ngspice":
        # PySpice is slow to import, and the native engine must not wait for it
        solve = partial(loaded("netlists.ngspice.sweep:solve_line"), deadline_s=deadline_s)
    start = read_voltages(asked.start, "--start") or None
    over = {each.name: each.values for each in swept}
    return Plan(build, units, over, choice.silicon, start, asked.way, solve, own_turned(asked.block, choice))


def _shown(asked: Sweep, choice: Choice, data: xr.Dataset) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Nodes and currents that are printed and drawn."""
    if "voltage" not in data:
        return (), ()
    known, devices = data.node.to_numpy().tolist(), data.device.to_numpy().tolist()
    for given, names, kind in ((asked.node, known, "node"), (asked.current, devices, "device or source")):
        for name in given:
            if name not in names:
                raise unknown_name(kind, name, names)
    swept = {source.node for source in choice.testbench().sources}
    usual = [n for n in choice.block.plotted if n in known] or [n for n in known if n != GROUND]
    if asked.node or asked.current:
        return asked.node, asked.current
    flows = [element for n in choice.block.plotted if (element := element_of(n)) in devices]
    return tuple(n for n in usual if n not in swept)[:_NODES], tuple(filter(None, flows))


def _csv(found: _Found) -> str:
    """A row a point: the swept values, then every voltage and current, or every measure."""
    data = found.data
    dims = list((data.voltage if found.points and not found.asked.measure else data.reason).dims)
    dims = [d for d in dims if d != "node"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns: dict[str, Any] = {}
    if found.points and not found.asked.measure:
        voltages, currents = (data[k].transpose(*dims, ...) for k in ("voltage", "current"))
        columns |= {f"v({n})_V": voltages.sel(node=n) for n in data.node.to_numpy()}
        columns |= {f"i({d})_A": currents.sel(device=d) for d in data.device.to_numpy()}
        columns["stable"] = data.stable.transpose(*dims).astype(int)
    else:
        for name in _measured(data):
            unit = data[name].attrs["units"]
            columns[f"{name}_{unit}" if unit else name] = data[name].transpose(*dims)
        columns["reason"] = data.reason.transpose(*dims)
    heads = [f"{d}_{data[d].attrs['units']}" if "units" in data[d].attrs else d for d in dims]
    writer.writerow([*heads, *columns])
    values = [each.to_numpy().ravel().tolist() for each in columns.values()]
    places = product(*(data[d].to_numpy().tolist() for d in dims))
    for place, *row in zip(places, *values, strict=True):
        writer.writerow([*place, *("" if isinstance(x, float) and math.isnan(x) else x for x in row)])
    return text.getvalue()


def _measured(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.data_vars if "expression" in data[name].attrs]


def _drawn(data: xr.Dataset) -> bool:
    return any(data[name].dims for name in _measured(data))


def _for_netcdf(data: xr.Dataset) -> xr.Dataset:
    failures = "\n".join(data.attrs["failures"])
    return data.assign_attrs(failures=failures)


def _document(found: _Found) -> dict[str, Any]:
    data, asked = found.data, found.asked
    dims = [str(d) for d in data.dims if d not in {"node", "device"}]
    document: dict[str, Any] = {
        "block": found.choice.block.name,
        **describe_silicon(found.choice.silicon),
        "engine": asked.engine,
        "analysis": asked.analysis,
        "stimuli": found.choice.stimuli,
        "over": [asdict(each) for each in found.swept],
        "way": asked.way,
        "dimensions": dims,
        "shape": [data.sizes[d] for d in dims],
        "measured": {
            name: {
                "unit": data[name].attrs["units"],
                "expression": data[name].attrs["expression"],
                "dimensions": [str(d) for d in data[name].dims],
                "values": data[name].to_numpy().ravel(),
            }
            for name in _measured(data)
        },
        "unmeasured": _reasons(data),
        "failures": data.attrs["failures"],
    }
    if found.points:
        nodes, devices = asked.node or data.node.to_numpy(), asked.current or data.device.to_numpy()
        document |= {
            "voltages_V": {str(n): data.voltage.sel(node=n).to_numpy().ravel() for n in nodes},
            "currents_A": {str(d): data.current.sel(device=d).to_numpy().ravel() for d in devices},
            "stable": data.stable.to_numpy().ravel(),
        }
    return {name: plain(value) for name, value in document.items()}


def _reasons(data: xr.Dataset) -> dict[str, int]:
    """How many measures have no value, by the reasons that they give."""
    if "reason" not in data:
        return {}
    said = (each for reason in data.reason.to_numpy().ravel() if reason for each in reason.split("; "))
    return dict(sorted(Counter(said).items(), key=lambda item: (-item[1], item[0])))


def _print(found: _Found) -> None:
    data, asked = found.data, found.asked
    where = f"{_place(found.choice, found.swept)}, {asked.engine}"
    print_line(f"{found.choice.block.name} at {where}: {_extent(found)}\n")
    if found.points:
        _print_points(found)
    if asked.measure:
        _print_measures(data)
    for reason, count in _reasons(data).items():
        print_line(f"{count} without {reason}")
    if found.points:
        unstable = int((~data.stable & data.voltage.notnull().all("node")).sum())
        if unstable:
            print_line(f"{unstable} points are not stable: a real circuit leaves them")
    for failure in data.attrs["failures"][:_SHOWN]:
        print_line(f"no solution: {failure}")


def _place(choice: Choice, swept: Sequence[Swept]) -> str:
    """The silicon in a line, but for what is swept of it."""
    names = {each.name for each in swept}
    if not names & {"temperature", "die", "corner"}:
        return silicon_line(choice.silicon)
    kept = [] if "temperature" in names else [f"{choice.silicon.temperature_c:g} degC"]
    kept += [] if names & {"die", "corner"} else [str(choice.silicon.die)]
    return ", ".join([*kept, choice.silicon.process.name])


def _extent(found: _Found) -> str:
    """What was swept, in words."""
    parts = []
    for each in found.swept:
        ends = [_cell(each.values[k], each.unit) for k in (0, -1)]
        values = ends[0] if len(each.values) == 1 else f"{ends[0]} to {ends[1]}, {len(each.values)} values"
        parts.append(f"{each.name} {values}")
    return "; ".join(parts)


def _print_points(found: _Found) -> None:
    data = found.data
    columns = [(f"{n}:", data.voltage.sel(node=n, drop=True), "V") for n in found.nodes]
    columns += [(f"i({d}):", data.current.sel(device=d, drop=True), "A") for d in found.currents]
    _print_columns("operating points", data, columns)


def _print_measures(data: xr.Dataset) -> None:
    columns = [(f"{name}:", data[name], data[name].attrs["units"]) for name in _measured(data)]
    _print_columns("measures", data, columns)


def _print_columns(title: str, data: xr.Dataset, columns: Sequence[tuple[str, xr.DataArray, str]]) -> None:
    """Print a row a point, the head and the end of many."""
    if not columns:
        return
    dims = [str(d) for d in columns[0][1].dims]
    heads = [f"{d}:" for d in dims]
    places = list(product(*(data[d].to_numpy().tolist() for d in dims)))
    values = [array.transpose(*dims).to_numpy().ravel().tolist() for _, array, _ in columns]
    rows = []
    for k in _rows(len(data[dims[0]]) if dims else 1, len(places)):
        place = [_cell(v, data[d].attrs.get("units", "")) for d, v in zip(dims, places[k], strict=True)]
        rows.append((*place, *(_cell(v[k], unit) for v, (_, _, unit) in zip(values, columns, strict=True))))
    print_table(title, (*heads, *(head for head, _, _ in columns)), rows)
    if len(places) > len(rows):
        print_line(f"{len(rows)} of {len(places)} points; --csv, --netcdf and --json have all\n")


def _rows(inner: int, count: int) -> list[int]:
    """Rows that are printed: all, or evenly spaced values of the innermost with all of the others."""
    others = count // inner
    few = max(_SHOWN // others, 2)
    chosen = sorted({round(k) for k in np.linspace(0, inner - 1, min(inner, few))})
    return [i * others + j for i in chosen for j in range(others)][: 2 * _SHOWN]


def _cell(value: Any, unit: str) -> str:
    if isinstance(value, str):
        return value
    return value_text(float(value), unit) if math.isfinite(value) else "-"


def _status(found: _Found) -> int:
    data = found.data
    empty = (
        bool(data.voltage.isnull().any("node").all())
        if found.points
        else all(bool(data[name].isnull().all()) for name in _measured(data))
    )
    if empty:
        first = next(iter((*data.attrs["failures"], *_reasons(data))), "")
        say(f"sweep: nothing at any point; {first}")
    return NO if empty else DONE
