"""`noctule run forest`: fly through a forest until a collision, and say how many obstacles were avoided."""

from __future__ import annotations

from typing import Any

from system.commands.output import print_json, print_line, print_table, progress_bar
from system.forest import SYSTEM, Scenario, Trace, read_options
from system.plot import check_picture, save_picture


def run_forest(system: str, seed: int, plot: str | None, *, as_json: bool, **options: Any) -> None:
    """Run one sample, print its summary; `plot` draws its first run. `options` are those of its scenario."""
    if plot is not None:
        check_picture(plot)
    scenario = Scenario(seed=seed, **read_options(options))
    with progress_bar(f"{system} (the first run compiles its kernels)") as progress:
        trace = SYSTEM.run(scenario, progress)
    summary = SYSTEM.summarise(trace)
    if plot is not None:
        save_picture(plot, lambda figure: SYSTEM.draw(trace, figure))
    if as_json:
        print_json(_document(system, trace, summary))
    else:
        _print(system, trace, summary)


def _document(system: str, trace: Trace, summary: dict[str, float | None]) -> dict[str, Any]:
    s, log = trace.scenario, trace.first.log
    return {
        "system": system,
        "map": s.map,
        "obstacles": len(trace.first.forest.place),
        "max_speed_m_per_s": s.bat.max_speed,
        "ping_rate_Hz": s.bat.ping_rate,
        "ranges": "exact",
        "zone_m": s.bat.zone,
        "seed": s.seed,
        "start_m": trace.first.start,
        "ended": trace.first.ended,
        "obstacles_m": trace.first.forest.place,
        "time_s": log[:, 0],
        "path_m": trace.path,
        "heading_rad": log[:, 3],
        "ping_direction": log[:, 4].astype(int),
        "arc": log[:, 5].astype(int),
        "scanning": log[:, 7].astype(bool),
        "summary": summary,
    }


def _print(system: str, trace: Trace, summary: dict[str, float | None]) -> None:
    first, bat = trace.first, trace.scenario.bat
    where = f"{first.start[0]:.2f},{first.start[1]:.2f} m"
    print_line(f"first run from {where}, {first.ended} at {first.end[0]:.2f},{first.end[1]:.2f} m")
    rows = [(name, "-" if value is None else f"{value:.6g}") for name, value in summary.items()]
    title = f"{system}, {len(first.forest.place)} obstacles, {bat.max_speed:g} m/s, {bat.ping_rate:g} Hz"
    print_table(title, ("quantity", "value:"), rows)
    if not trace.sample.collided:
        print_line(f"undecided after {trace.sample.pings} pings: no collision; --pings N flies on")
