"""Lines and the block are made of the same devices."""

from collections.abc import Sequence

import pytest

from circuits.blocks.bias.generator import Params, build
from circuits.devices import Device, Transistor
from circuits.generator.circuit import NARROW, WIDE, line, line_sizes, masters
from circuits.generator.code import COARSE
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ROLLS_180, ROLLS_180_IDEAL, Polarity, Process


def sizes(devices: Sequence[Device]) -> dict[str, tuple[float, ...]]:
    return {d.name: tuple(d.parameters().values()) for d in devices}


def device(polarity: Polarity, width: float = 6e-6, length: float = 6e-6) -> Transistor:
    return Transistor("m", polarity, "d", "g", "s", "b", width, length, 2.0)


@pytest.mark.parametrize("polarity", ["n", "p"])
def test_a_line_and_its_masters_have_the_sizes_of_the_block(polarity: Polarity) -> None:
    params = Params(coarse=5, fine=125)
    block = sizes(build(params).devices)
    own = sizes(masters(params.core_resistance, [WIDE] * len(COARSE))) | sizes(line(125, device(polarity)))
    del own["mdn" if polarity == "n" else "mdp"]  # the output device is as large as what it biases
    assert own.items() <= (block | {f"mr1_{k}": block["mr1"] for k in range(8)}).items()


@pytest.mark.parametrize(("polarity", "name"), [("n", "mdn"), ("p", "mdp")])
def test_the_output_device_is_as_large_as_what_it_biases(polarity: Polarity, name: str) -> None:
    assert sizes(line(1, device(polarity, 3e-6, 30e-6)))[name] == (3e-6, 30e-6, 2.0)


def test_codes_differ_in_the_gates_of_switches_alone() -> None:
    one, other = line(128, device("n")), line(127, device("n"))
    changed = {a.name for a, b in zip(one, other, strict=True) if a != b}
    assert changed == {f"mf{way}{k}" for way in "sd" for k in range(8)}


@pytest.mark.parametrize(
    ("process", "narrow"),
    [(AMI_1500, 0), (AMI_1500_IDEAL, 0), (ROLLS_180, 4), (ROLLS_180_IDEAL, 4)],
    ids=lambda p: getattr(p, "name", p),
)
def test_lines_of_small_currents_are_narrow_where_devices_that_are_off_carry_more(
    process: Process, narrow: int
) -> None:
    assert line_sizes(process) == (WIDE,) * (len(COARSE) - narrow) + (NARROW,) * narrow
