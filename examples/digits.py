"""Digits in a grid of 5 x 7 points, and a network that tells them apart: for noctule map, train, certify."""

from __future__ import annotations

import numpy as np

from system.api.network import Connection, Input, Network, Population, Probe, write_network

GLYPHS = (
    "01110 10001 10011 10101 11001 10001 01110", "00100 01100 00100 00100 00100 00100 01110",
    "01110 10001 00001 00110 01000 10000 11111", "11111 00010 00100 00010 00001 10001 01110",
    "00010 00110 01010 10010 11111 00010 00010", "11111 10000 11110 00001 00001 10001 01110",
    "00110 01000 10000 11110 10001 10001 01110", "11111 00001 00010 00100 01000 01000 01000",
    "01110 10001 10001 01110 10001 10001 01110", "01110 10001 10001 01111 00001 00010 01100",
)  # fmt: skip
NOISE, FLIPPED, HIGHEST = 0.25, 0.08, 400.0  # of a point's brightness; share of points; Hz of a bright one
CELLS, DRIVE, WINDOW = 6, 0.6, 0.1  # neurons an output; weight of the strongest point; s a sample


def samples(count, rng):
    """Noisy digits, float64[count, 35], and which they are."""
    plain = np.array([[int(c) for c in glyph.replace(" ", "")] for glyph in GLYPHS], dtype=float)
    labels = rng.integers(len(GLYPHS), size=count)
    flipped = rng.random((count, 35)) < FLIPPED
    points = np.abs(plain[labels] - flipped) + rng.normal(0.0, NOISE, (count, 35))
    return points.clip(0.0, 1.0), labels


def trained(points, labels):
    """Weights of a linear classifier by regularised least squares, float64[10, 35], the largest of them 1."""
    targets = 2.0 * np.eye(len(GLYPHS))[labels] - 1.0
    weights = np.linalg.solve(points.T @ points + 50.0 * np.eye(35), points.T @ targets).T
    weights /= np.abs(weights).max()
    return np.where(np.abs(weights) < 0.05, 0.0, weights)


def main():
    """Write digits.toml, digits-training.npz, and digits.npz with samples that it was not trained on."""
    points, labels = samples(2000, np.random.default_rng(0))
    np.savez_compressed("digits-training.npz", inputs=HIGHEST * points, labels=labels, window_s=WINDOW)
    weights = trained(points, labels)
    outputs = [f"digit{k}" for k in range(len(GLYPHS))]
    connections = [
        Connection("points", name, rule="matrix", tau=20e-3, matrix=np.tile(DRIVE * row, (CELLS, 1)))
        for name, row in zip(outputs, weights, strict=True)
    ]
    write_network(
        "digits.toml",
        Network(
            tuple(Population(name, CELLS) for name in outputs),
            (Input("points", 35),),
            tuple(connections),
            tuple(Probe(f"is {k}", name) for k, name in enumerate(outputs)),
        ),
    )
    points, labels = samples(60, np.random.default_rng(1000))
    np.savez_compressed("digits.npz", inputs=HIGHEST * points, labels=labels, window_s=WINDOW)
    print(f"linear classifier: {(np.argmax(points @ weights.T, axis=1) == labels).mean():.1%} right")


if __name__ == "__main__":
    main()
