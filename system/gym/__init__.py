"""Robots as environments of Gymnasium, an optional extra; importing it registers them.

`gymnasium.make("system.gym:noctule/Forest-v0")` imports it by itself.
"""

from system.gym.registration import register_all

register_all()
