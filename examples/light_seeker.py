"""A robot of one's own: two wheels, two light sensors, a lamp; by its program, then by a chip on a die."""

from __future__ import annotations

import numpy as np

from chips.api import open_chip
from chips.api.rolls import QUIET, VIRTUAL_EXCITATORY, Network, PopulationInput, network_program, place, table
from circuits.api import Die
from system.api.play import Channel, ChipPolicy, LiveRun, Ranges, RateCode, RateDecoder, Signals


class Seeker:
    """A robot that ends at the lamp; its sensors look 45 degrees to either side."""

    senses = Signals((Channel("light, left and right", "", 0.0, 1.0, (2,)),))
    actions = Signals((Channel("speed of the wheels, left and right", "m/s", -0.2, 0.2, (2,)),))

    def __init__(self, seed=0):
        random = np.random.default_rng(seed)
        self.place, self.heading = (0.0, 0.0), float(random.uniform(-np.pi, np.pi))
        angle = random.uniform(-np.pi, np.pi)
        self.lamp, self.path = np.array([np.cos(angle), np.sin(angle)]), [(0.0, 0.0)]
        self.time, self.reward = 0.0, 0.0

    distance = property(lambda self: float(np.hypot(*(self.lamp - self.place))))
    ended = property(lambda self: "at the lamp" if self.distance < 0.1 else "")
    late = property(lambda self: "time of 60 s over" if self.time >= 60.0 else "")
    succeeded = property(lambda self: bool(self.ended))

    def sense(self):
        """Light on both sensors."""
        towards = np.arctan2(*(self.lamp - self.place)[::-1]) - self.heading
        return np.cos(towards - np.array([1.0, -1.0]) * np.pi / 4.0).clip(0.0, 1.0)

    readings = sense

    def own(self):
        """Each sensor drives the wheel of the other side."""
        return 0.03 + 0.15 * self.sense()[::-1]

    def act(self, action):
        """Drive for 50 ms."""
        before, (left, right) = self.distance, action
        self.heading += 0.05 * (right - left) / 0.1
        step = 0.05 * 0.5 * (left + right) * np.array([np.cos(self.heading), np.sin(self.heading)])
        self.place, self.time = tuple(np.add(self.place, step).tolist()), self.time + 0.05
        self.path.append(self.place)
        self.reward = before - self.distance

    def draw(self, ax):
        """Draw the way and the lamp."""
        ax.plot(*np.array(self.path).T)
        ax.plot(*self.lamp, "*")


def crossed(die):
    """Each sensor drives 32 neurons of a die, and their rate the wheel of the other side."""
    sides = place({"left": 32, "right": 32})
    inputs = tuple(PopulationInput(name, side) for name, side in sides.items())
    program = network_program(Network(tuple(sides.values()), inputs=inputs), table(QUIET, {}))
    addresses = [[n + (VIRTUAL_EXCITATORY << 8) for n in side.neurons] for side in sides.values()]
    matrix = 0.15 / 100.0 * np.array([[0.0, 1.0], [1.0, 0.0]])  # 100 Hz are 0.15 m/s
    decoder = RateDecoder([side.neurons for side in sides.values()], matrix, tau=0.1, offset=0.03)
    code = RateCode(Ranges((0.0, 0.0), (1.0, 1.0), addresses), most=800.0)
    policy = ChipPolicy(open_chip("rolls", die, program=program), code, decoder, window=0.05)
    return lambda seen: np.clip(policy(seen), -0.2, 0.2)


def main():
    """Run it by its own program, then by the chip on two dies."""
    for name, controller in {
        "program": None, "die A/1000": crossed(Die("A", 1000)), "die A/1001": crossed(Die("A", 1001)),
    }.items():  # fmt: skip
        run = LiveRun(Seeker(seed=1000), controller)
        way = 0.0
        while not run.over:
            way += run.take(run.look().action)
        print(f"{name}: {run.over} after {run.robot.time:.1f} s, {way:.2f} m nearer")


if __name__ == "__main__":
    main()
