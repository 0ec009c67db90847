"""Runs step by step: a robot under a controller of one's own, and a chip as that controller."""

from system.live.robot import LiveRobot
from system.live.signals import Channel, Signals
from system.play.decoder import LatencyDecoder, PopulationDecoder, RateDecoder, VoteDecoder
from system.play.encoder import LatencyCode, PopulationCode, Ranges, RateCode
from system.play.policy import ChipPolicy
from system.play.run import LiveRun, open_run

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Runs step by step
    "open_run",
    "LiveRun",
    "LiveRobot",
    "Signals",
    "Channel",
    # A chip as a controller
    "ChipPolicy",
    "Ranges",
    "RateCode",
    "LatencyCode",
    "PopulationCode",
    "RateDecoder",
    "VoteDecoder",
    "LatencyDecoder",
    "PopulationDecoder",
]
