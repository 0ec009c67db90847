"""Where a NEF chip's model holds: within where its parts were held against their transistors.

All numbers are ours, of dies from which nothing was made, biases fixed at 27 degC:

| part | at | error |
|---|---|---|
| neuron, rate, 4 dies, both kinds of biases | -20 to 60 degC, the area, a 16th and 0.03 of it | 1.9 % |
| the same | 75, 85 and 125 degC | 2.8, 4.4 and 18 % |
| the same | a hundredth of the area | 3.6 % |
| stage of an encoder, its current, 2 dies, gate biases | -20 to 60 degC | 2.2 % |
| filter, its output, nominal, both kinds | -20 to 60 degC | 4.9 % |
| the same | 75 and 85 degC | 5.9 and 7.3 % |
| neuron, rate, full law, 2 dies, three kinds | -20 degC | 0.5 % |
"""

from __future__ import annotations

from chips.validity import require_area, require_inside

PATH = "nef_chip"
TEMPERATURES = (-20.0, 60.0)  # degC
LEAST_AREA = 0.03  # of the devices
_REMEDY = "stay within"


def check_box(calibration_c: float, temperature_c: float, area: float) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for a chip outside the box.

    calibration_c, temperature_c: where it is calibrated and where it is used, degC; area: of its devices over
    the circuits'.
    """
    check_temperature("calibration", calibration_c)
    check_temperature("temperature", temperature_c)
    require_area(PATH, area, LEAST_AREA, _REMEDY)


def check_temperature(name: str, celsius: float) -> None:
    """Raise `ParameterError`, as `chips.validity` says, for one outside, degC; name: of the side."""
    require_inside(f"{PATH}.{name}", celsius, TEMPERATURES, "degC", _REMEDY)
