"""A rover that does not know its map: it learns what it drives over, and finds the road (equation 5)."""

from __future__ import annotations

from system.rover.body import Rover
from system.rover.run import run
from system.rover.scenario import Scenario

# A receiver good to a metre: with a phone's 3 m of drift what is sensed lands in the wrong cell too often.
ROVER = Rover(reach=3.0, gps_drift=1.0, gps_noise=0.2, outage_rate=0.0, outage_rate_covered=0.0)
TRIPS = 40


def main() -> None:
    """Print every fifth trip of a rover that takes unknown cells for cheap, and of one that does not."""
    print(f"cost of the way above the lowest, every fifth of {TRIPS} trips")
    for prior in (1.0, 5.0):
        found = run(Scenario(map="map1-road", learn=0.5, prior=prior, trips=TRIPS, rover=ROVER))
        regrets = " ".join(str(trip.plan.regret) for trip in found.trips[::5])
        print(f"unknown cells taken for {prior:g}: {regrets}")


if __name__ == "__main__":
    main()
