"""Three arms of a spiral, and a network of values that tells them apart: for noctule map, train, certify."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import minimize

ARMS, TURN, NOISE = 3, 0.5, 0.03  # arms; turns from the middle to the end; of a point's place, in radii
UNITS, DECAY = 8, 1e-4  # hidden numbers; of the weights
HIDDEN, OUTER, WINDOW = 240, 120, 0.08  # neurons; s a sample

NETWORK = """ensemble = [
    {{ name = "hidden", neurons = {HIDDEN}, dimensions = {UNITS} }},
    {{ name = "arms", neurons = {OUTER}, dimensions = {ARMS} }},
]
input = [{{ name = "place", size = 3 }}]
probe = [{{ name = "arm", ensemble = "arms" }}]
connection = [
    {{ from = "place", to = "hidden", transform = {first} }},
    {{ from = "hidden", to = "arms", function = "positive", transform = {second} }},
]
"""


def samples(count, rng):
    """Points on the arms with a constant beside, float64[count, 3], and which arm they are of."""
    labels, along = rng.integers(ARMS, size=count), rng.uniform(0.1, 1.0, count)
    angle = 2.0 * np.pi * (TURN * along + labels / ARMS)
    place = along[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    place += rng.normal(0.0, NOISE, place.shape)
    return np.column_stack([place, np.ones(count)]), labels


def trained(inputs, labels, rng):
    """Weights of a perceptron with a hidden layer, which knows nothing of chips."""
    asked = np.eye(ARMS)[labels]

    def parts(flat):
        return flat[: 3 * UNITS].reshape(UNITS, 3), flat[3 * UNITS :].reshape(ARMS, UNITS)

    def loss(flat):
        """Cross-entropy with decay of the weights, and its derivatives."""
        first, second = parts(flat)
        hidden = np.maximum(inputs @ first.T, 0.0)
        share = np.exp(hidden @ second.T)
        share /= share.sum(axis=1, keepdims=True)
        back = (share - asked) / len(labels)
        by = [((back @ second) * (hidden > 0.0)).T @ inputs, back.T @ hidden]
        lost = -np.log((share * asked).sum(axis=1)).mean() + 0.5 * DECAY * flat @ flat
        return lost, np.concatenate([g.ravel() for g in by]) + DECAY * flat

    found = minimize(loss, rng.normal(size=(3 + ARMS) * UNITS), jac=True, method="L-BFGS-B")
    return parts(found.x)


def scaled(weights, inputs):
    """The same perceptron with hidden and outer numbers of at most the length 1."""
    first, second = weights
    first = first / np.linalg.norm(inputs @ first.T, axis=1).max()
    second = second / np.linalg.norm(np.maximum(inputs @ first.T, 0.0) @ second.T, axis=1).max()
    return first, second


def main():
    """Write spiral.toml, spiral-training.npz, and spiral.npz with samples that it was not trained on."""
    inputs, labels = samples(2000, np.random.default_rng(0))
    np.savez_compressed("spiral-training.npz", inputs=inputs, labels=labels, window_s=WINDOW)
    first, second = scaled(trained(inputs, labels, np.random.default_rng(1)), inputs)
    matrices = {"first": first.round(4).tolist(), "second": second.round(4).tolist()}
    Path("spiral.toml").write_text(NETWORK.format(**globals(), **matrices), encoding="utf-8")
    inputs, labels = samples(200, np.random.default_rng(1000))
    np.savez_compressed("spiral.npz", inputs=inputs, labels=labels, window_s=WINDOW)
    found = np.argmax(np.maximum(inputs @ first.T, 0.0) @ second.T, axis=1)
    print(f"perceptron: {(found == labels).mean():.1%} right")


if __name__ == "__main__":
    main()
