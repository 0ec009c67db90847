"""The verb `noctule simulate --analysis noise`: noise at a node about the rest state of a block."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.devices.noise import WHITE_ONLY, noise_model
from circuits.errors import ParameterError
from circuits.solver.noise.analysis import Noise, noise
from circuits.solver.operating_point import OperatingPoint
from system.cli import small_signal_runs
from system.cli.output import print_json, print_table
from system.cli.simulate_verb import Simulate
from system.cli.small_signal_picture import draw_noise
from system.files.writing import write_netcdf_atomic, write_text_atomic
from system.options.block import Choice
from system.plot import check_picture, save_picture

if TYPE_CHECKING:
    import xarray as xr


def noise_command(asked: Simulate) -> None:
    """Print the noise at the node `--node` by device, and write the files that are asked for.

    Where `--source` names a source, the noise is also referred to that.
    """
    frequency, white = small_signal_runs.frequencies_of(asked), asked.flicker is False
    if len(asked.node) not in {1, 2}:
        text = f"--node: {len(asked.node)} given, --analysis noise needs one output, or two for v(A,B)"
        raise ParameterError(f"{text}; as --node v_mem")
    node, reference = asked.node[0], asked.node[1] if asked.node[1:] else None
    check_picture(asked.plot)

    def solve(point: OperatingPoint, choice: Choice) -> Noise:
        model = WHITE_ONLY if white else noise_model(choice.silicon.process)
        return noise(point, node, frequency, asked.source, model, reference)

    runs = small_signal_runs.runs_of(asked, solve)
    found = [(run, run.answer) for run in runs if run.answer is not None]
    if asked.csv is not None:
        write_text_atomic(asked.csv, _noise_csv(found))
    if asked.netcdf is not None:
        write_netcdf_atomic(asked.netcdf, _noise_dataset(runs))
    save_picture(
        asked.plot, lambda figure: draw_noise([(small_signal_runs.label_of(r), n) for r, n in found], figure)
    )
    if asked.as_json:
        document = {
            **small_signal_runs.head_of(asked, runs), "node": found[0][1].node, "source": asked.source,
            "referred_unit": found[0][1].unit if asked.source else None,
            "flicker": not white, "frequency_Hz": frequency,
            "runs": [_noise_run(run) for run in runs],
        }  # fmt: skip
        print_json(document)
    else:
        _print_noise(found)
        small_signal_runs.print_failures(runs)


def _noise_run(run: small_signal_runs.Run[Noise]) -> dict[str, Any]:
    found = run.answer
    if found is None:
        return small_signal_runs.place_of(run)
    shares = found.shares()
    white, flicker = (sum(s[k] for s in shares.values()) for k in (0, 1))
    devices = [
        {
            "device": n,
            "white_V2": w,
            "flicker_V2": f,
            "share": (w + f) / found.variance if found.variance else 0,
        }
        for n, (w, f) in shares.items()
    ]
    return {
        **small_signal_runs.place_of(run), "rms_V": found.variance**0.5,
        "white_rms_V": white**0.5, "flicker_rms_V": flicker**0.5,
        "output_V2_per_Hz": found.output, "referred_per_Hz": found.referred, "contributions": devices,
    }  # fmt: skip


def _noise_csv(found: Sequence[tuple[small_signal_runs.Run[Noise], Noise]]) -> str:
    lines = ["temperature_C,die,frequency_Hz,white_V2_per_Hz,flicker_V2_per_Hz,referred_per_Hz"]
    for run, answer in found:
        none = np.full_like(answer.frequency, np.nan)
        referred = none if answer.referred is None else answer.referred
        columns = (answer.white.sum(axis=1), answer.flicker.sum(axis=1), referred)
        lines += [
            small_signal_runs.row_of(run, f, row) for f, *row in zip(answer.frequency, *columns, strict=True)
        ]
    return "\n".join(lines) + "\n"


def _noise_dataset(runs: Sequence[small_signal_runs.Run[Noise]]) -> xr.Dataset:
    """White and flicker by device over temperature, die, frequency; NaN where one failed."""
    one = next(run.answer for run in runs if run.answer is not None)
    empty = np.full(one.white.shape, np.nan)
    dims = ("frequency", "device")
    parts = {
        name: (
            dims,
            np.array([empty if r.answer is None else getattr(r.answer, name) for r in runs]),
            "V^2/Hz",
        )
        for name in ("white", "flicker")
    }
    if one.gain is not None:
        gains = [empty[:, 0] if r.answer is None or r.answer.gain is None else r.answer.gain for r in runs]
        parts["gain"] = (("frequency",), np.array(gains), "V/V" if one.unit == "V^2/Hz" else "V/A")  # type: ignore[assignment]
    data = small_signal_runs.dataset_of(runs, parts)
    data = data.assign_coords(frequency=one.frequency, device=list(one.devices))
    return data.assign_attrs(node=one.node, source=one.source or "")


def _print_noise(found: Sequence[tuple[small_signal_runs.Run[Noise], Noise]]) -> None:
    first = found[0][1]
    title = f"noise at {first.node}, {first.frequency[0]:g} to {first.frequency[-1]:g} Hz"
    rows = []
    for run, answer in found:
        shares = answer.shares()
        white, flicker = (1e6 * sum(s[k] for s in shares.values()) ** 0.5 for k in (0, 1))
        total = f"{1e6 * answer.variance**0.5:.5g} uV"
        stable = "yes" if run.stable else "NO"
        rows.append((small_signal_runs.label_of(run), total, f"{white:.5g} uV", f"{flicker:.5g} uV", stable))
    print_table(title, ("silicon", "rms:", "white:", "flicker:", "stable"), rows)
    run, answer = found[0]
    variance = answer.variance or 1.0
    largest = list(answer.shares().items())[:10]
    parts = [(n, f"{100 * w / variance:.2f} %", f"{100 * f / variance:.2f} %") for n, (w, f) in largest]
    print_table(
        f"shares of the variance, {small_signal_runs.label_of(run)}", ("device", "white:", "flicker:"), parts
    )
