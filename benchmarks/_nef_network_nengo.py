"""nengo's side of `nef_network`: the network of a pickle file, run; prints CPU time and the rays' mean."""

import json
import pickle
import sys
import time
from pathlib import Path

import nengo
import numpy as np


def main():
    """Build, run, print."""
    given = pickle.loads(Path(sys.argv[1]).read_bytes())  # noqa: S301 - written by the script that started it
    model, rays = network_of(given)
    with nengo.Simulator(model, dt=0.001, optimize=True, progress_bar=False) as simulator:
        simulator.run(given["settling"])
        start = time.process_time()
        simulator.run(given["duration"])
        seconds = time.process_time() - start
        steps = round(given["duration"] / 0.001)
        means = [float(simulator.data[ray][-steps:].mean()) for ray in rays]
    print(json.dumps({"seconds": seconds, "rays": means}))


def network_of(given):
    """The network, and the probes of its rays."""
    with nengo.Network(seed=0) as model:
        ends = {}
        for part in given["parts"]:
            ends[part["name"]] = [ensemble_of(part) for _ in range(part["count"])]
        nodes = {}
        for node in given["nodes"]:
            value = np.broadcast_to(np.asarray(node["value"], dtype=float), (node["size"],))
            nodes[node["name"]] = nengo.Node(value)
        for joined in given["connections"]:
            connect(joined, ends, nodes)
        (synapse,) = [p["synapse"] for p in given["probes"] if p["name"] == "rays?"]
        return model, [nengo.Probe(ray, synapse=synapse) for ray in ends["rays"]]


def ensemble_of(part):
    """An ensemble; encoders in turn, where they are given."""
    n, d = part["neurons"], part["dimensions"]
    encoders = part["encoders"]
    options = {"encoders": np.array([encoders[k % len(encoders)] for k in range(n)])} if encoders else {}
    return nengo.Ensemble(
        n,
        d,
        radius=part["radius"],
        max_rates=nengo.dists.Uniform(*part["max_rates"]),
        intercepts=nengo.dists.Uniform(*part["intercepts"]),
        **options,
    )


def connect(joined, ends, nodes):
    """Wire every population before the connection to every one behind it."""
    pres = ends.get(joined["pre"]) or [nodes[joined["pre"]]]
    posts = ends[joined["post"]]
    results = joined["values"].shape[1] if "values" in joined else pres[0].size_out
    total = results * len(pres)
    transform = np.atleast_2d(joined["transform"])
    if joined["transform"].ndim == 0:
        transform = float(joined["transform"]) * np.eye(total)
    for k, pre in enumerate(pres):
        options = {"synapse": joined["synapse"]}
        if "values" in joined:
            options |= {"function": joined["values"], "eval_points": joined["points"]}
            options["scale_eval_points"] = False
        own = transform[:, k * results : (k + 1) * results]
        for j, post in enumerate(posts):
            if joined["neurons"]:
                nengo.Connection(
                    pre, post.neurons, transform=np.repeat(own, post.n_neurons, axis=0), **options
                )
                continue
            d = post.size_in
            rows = own[j * d : (j + 1) * d]
            if rows.any():
                nengo.Connection(pre, post, transform=rows, **options)


if __name__ == "__main__":
    main()
