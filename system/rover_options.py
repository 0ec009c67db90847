"""Options of a study of the rover, as the command line declares them."""

from __future__ import annotations

from typing import Annotated

import typer

MapName = Annotated[
    str | None, typer.Option("--map", metavar="MAP", help="Of rover: map1-road, ... or a file of costs.")
]
RouteStart = Annotated[
    str | None, typer.Option("--start", metavar="ROW,COLUMN", help="Of rover: from 0, row 0 in the north.")
]
RouteGoal = Annotated[str | None, typer.Option("--goal", metavar="ROW,COLUMN", help="Of rover: as --start.")]
UnitDelay = Annotated[
    str | None, typer.Option("--unit", metavar="TIME", help="Of rover's chip: delay a unit of cost; 100us.")
]
