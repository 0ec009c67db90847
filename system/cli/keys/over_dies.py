"""Keys of `noctule match`, `noctule worst` and `noctule corners`."""

from __future__ import annotations

from system.meaning import meanings

MATCH = meanings("""
block          string   -     name of the block
metric         string   -     metric that is matched
unit           string   -     its unit
temperature_C  number   degC  temperature
value          number   -     its value on the nominal die, in its unit
note           string   -     where it is not smooth; empty where it is
by             string   -     where the gradient comes from
runs           integer  -     runs of the testbench, one backwards counted as three
spread         number   -     its standard deviation over dies in the linear theory, in its unit
spread_fixed   number   -     that which the process alone makes
spread_wanted  number   -     that which the wanted areas give
area_m2        number   m^2   area of all devices
area_wanted_m2 number   m^2   the same with the wanted areas
devices        object[] -     devices, those that add most to the variance first
devices.device          string  -    name
devices.share           number  -    what it adds to the variance, of all
devices.area_m2         number  m^2  its area
devices.area_wanted_m2  number  m^2  the area that it should get
checks          object[]  -  what sampled dies show, on the same draws; none without `--check`
checks.name     string    -  which dies
checks.defined  integer   -  how many of these have the metric
checks.spread   number?   -  its standard deviation over them, in its unit
checks.interval       object   -  its 95 % interval
checks.interval.low   number?  -  lower end
checks.interval.high  number?  -  upper end; null where there are too few dies
""")
WORST = meanings("""
block           string    -  name of the block
specifications  object[]  -  what was found for each specification
specifications.specification  string    -  it
specifications.unit           string    -  unit of its metric
specifications.by             string    -  where gradients come from
specifications.runs           integer   -  runs of the search, one backwards counted as three
specifications.failing        number    -  probability that a die fails, without sampling
specifications.cases          object[]  -  the worst die of each limit
specifications.beyond         string[]  -  sides of limits that no die within 8 sigma fails
specifications.cases.side     string    -  `below` where lower values fail, `above` where higher ones do
specifications.cases.limit    number    -  the limit, in the metric's unit
specifications.cases.distance number    -  worst-case distance in sigma; below 0 where the nominal die fails
specifications.cases.failing  number    -  probability that a die fails at this limit
specifications.cases.value    number    -  metric as measured on the worst die
specifications.cases.verified boolean   -  whether it fails, and one just on this side of the limit passes
specifications.cases.die_file string?   -  file of the die; null without `--output`
specifications.cases.moves    object[]  -  draws of the die, the largest first
specifications.cases.moves.draw   string  -  label of the draw
specifications.cases.moves.sigma  number  -  by how many sigma it deviates
specifications.check       object?  -  the same probability by dies drawn about the worst; null without
specifications.check.method             string   -  how it was estimated
specifications.check.probability        number   -  the estimate
specifications.check.interval           object   -  its 95 % interval
specifications.check.interval.low       number   -  lower end
specifications.check.interval.high      number   -  upper end
specifications.check.samples            integer  -  dies that were measured
specifications.check.effective_samples  number   -  samples of equal weight that say as much
specifications.check.detail             string   -  how it went, in a line
specifications.check_note  string   -  why there is no check; empty where there is one, or none was asked for
""")
CORNERS = meanings("""
block             string    -  name of the block
corners           object[]  -  the low and the high corner of each metric
corners.metric    string    -  metric
corners.unit      string    -  its unit
corners.sigma     number    -  distance of the die; below 0 where the metric is low
corners.value     number    -  metric as measured on that die, in its unit
corners.by        string    -  where gradients come from
corners.die_file  string?   -  file of the die; null without `--output`
""")
