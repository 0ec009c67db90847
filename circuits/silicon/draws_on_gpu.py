"""Draws of very many dies on a graphics processor: those of `circuits.silicon.die`.

A thread makes one draw: the key of its path is the hash of owner and names as there, the counter are its
indices, and the number is Philox's, through the inverse of the normal's integral (`circuits.silicon.normal`).
Keys, words and probabilities are the same to the bit (tested), and so are draws in the middle of the
distribution; those of the tails may differ in their last bits, where the device's logarithm does.

Source: Saarinen, Aumasson, "The BLAKE2 Cryptographic Hash and Message Authentication Code", RFC 7693 (2015).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any

import numpy as np

from circuits.arrays import F64, I64
from circuits.programs import gpu
from circuits.silicon import normal
from circuits.silicon.die import Places, hashed

_BYTES = 128  # of a block of the hash
_ROUNDS = (
    "0123456789abcdef", "ea489fd61c02b753", "b8c052fdae367194", "7931dcbe265a40f8", "905724afe1bc683d",
    "2c6a0b834d75fe19", "c51fed4a0763928b", "db7ec13950f4862a", "6fe9b308c2d714a5", "a2847615fb9e3cd0",
    "0123456789abcdef", "ea489fd61c02b753",
)  # fmt: skip
"""Which word of a block goes into which step of a round."""
_BEGIN = (
    0x6A09E667F3BCC908, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B, 0xA54FF53A5F1D36F1, 0x510E527FADE682D1,
    0x9B05688C2B3E6C1F, 0x1F83D9ABFB41BD6B, 0x5BE0CD19137E2179,
)  # fmt: skip
_STEPS = (
    (0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
    (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14),
)  # fmt: skip

_TEXT = """
typedef unsigned long long word;
__device__ word turned(word x, int by) { return (x >> by) | (x << (64 - by)); }
#define STEP(a, b, c, d, x, y) \\
    v[a] += v[b] + (x); v[d] = turned(v[d] ^ v[a], 32); v[c] += v[d]; v[b] = turned(v[b] ^ v[c], 24); \\
    v[a] += v[b] + (y); v[d] = turned(v[d] ^ v[a], 16); v[c] += v[d]; v[b] = turned(v[b] ^ v[c], 63);
__device__ void fold(word *h, const word *m, word bytes, int last) {
    word v[16] = {BEGIN8, BEGIN8};
    for (int i = 0; i < 8; i++) v[i] = h[i];
    v[12] ^= bytes;
    if (last) v[14] = ~v[14];
    ALL_ROUNDS
    for (int i = 0; i < 8; i++) h[i] ^= v[i] ^ v[i + 8];
}
__device__ word key_of(
        const unsigned char *one, long long first, const unsigned char *other, long long second) {
    word h[8] = {BEGIN8}, m[16];
    h[0] ^= 0x01010000ULL ^ 8;
    h[6] ^= PERSON0; h[7] ^= PERSON1;
    const long long size = first + second;
    long long at = 0;
    do {
        for (int w = 0; w < 16; w++) {
            m[w] = 0;
            for (int b = 0; b < 8; b++, at++) {
                const word byte = at < first ? one[at] : at < size ? other[at - first] : 0;
                m[w] |= byte << (8 * b);
            }
        }
        fold(h, m, at < size ? at : size, at >= size);
    } while (at < size);
    return h[0];
}
__device__ double eight(double x, double begun, const double *c) {
    double y = begun;
    for (int i = 0; i < 8; i++) y = y * x + c[i];
    return y;
}
__device__ double draw(word key, const unsigned *counter) {
    const word low = 0xFFFFFFFFULL;
    word c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3], k0 = key & low, k1 = key >> 32;
    for (int i = 0; i < 10; i++) {
        const word p0 = 0xD2511F53ULL * c0, p1 = 0xCD9E8D57ULL * c2;
        c0 = (p1 >> 32) ^ c1 ^ k0; c1 = p1 & low; c2 = (p0 >> 32) ^ c3 ^ k1; c3 = p0 & low;
        k0 = (k0 + 0x9E3779B9ULL) & low; k1 = (k1 + 0xBB67AE85ULL) & low;
    }
    TABLES
    double p = ((double) (long long) ((c0 << 21) ^ (c1 >> 11)) + 0.5) * CELL;
    const int upper = p > 1.0 - TAIL;
    p = upper ? 1.0 - p : p;
    if (p > TAIL) {
        const double y = p - 0.5, y2 = y * y;
        const double four = (((p0_[0] * y2 + p0_[1]) * y2 + p0_[2]) * y2 + p0_[3]) * y2 + p0_[4];
        return (y + y * (y2 * four / eight(y2, 1.0, q0_))) * ROOT;
    }
    double x = sqrt(-2.0 * log(p));
    const double z = 1.0 / x, more = x < FAR ? z * eight(z, p1_[0], p1_ + 1) / eight(z, 1.0, q1_)
                                             : z * eight(z, p2_[0], p2_ + 1) / eight(z, 1.0, q2_);
    x = x - log(x) / x - more;
    return upper ? x : -x;
}
extern "C" __global__ void draw_all(
        const unsigned char *owners, const long long *owner_sizes, long long owner_room,
        const unsigned char *names, const long long *name_sizes, long long name_room, const long long *path,
        const unsigned *counters, long long places, long long count, double *drawn) {
    const long long k = (long long) blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count) return;
    const long long owner = k / places, place = k % places, name = path[place];
    const word key = key_of(owners + owner * owner_room, owner_sizes[owner],
                            names + name * name_room, name_sizes[name]);
    drawn[k] = draw(key, counters + 4 * place);
}
"""


def normals_on_gpu(owners: Sequence[str], names: Sequence[str], places: Places, parameter: str) -> F64:
    """What `circuits.silicon.die.normals_of` gives; raises ParameterError without a graphics processor."""
    cp = gpu.cupy()
    function = gpu.function_of(_text(), "draw_all", "-fmad=false")  # as the processor rounds
    path, counters = places.counters()
    count, drawn = len(owners) * path.size, cp.zeros((len(owners), path.size), cp.float64)
    texts_given: list[Any] = [*_owners(tuple(owners)), *_padded(hashed(names, parameter))]
    given: list[Any] = [gpu.on_device(x) if isinstance(x, np.ndarray) else np.int64(x) for x in texts_given]
    given += [gpu.on_device(path), gpu.on_device(counters), np.int64(path.size), np.int64(count), drawn]
    function((-(-count // gpu.THREADS),), (gpu.THREADS,), tuple(given))
    return np.asarray(drawn.get())


@lru_cache(maxsize=16)  # of which all parameters are drawn one after the other
def _owners(owners: tuple[str, ...]) -> tuple[np.ndarray, I64, int]:
    return _padded([owner.encode() for owner in owners])


def _padded(texts: Sequence[bytes]) -> tuple[np.ndarray, I64, int]:
    """Texts, none of which ends in a 0, as rows of bytes; their lengths, and the bytes of a row."""
    rows = np.array(texts)
    return rows.view(np.uint8).reshape(len(texts), -1), np.char.str_len(rows), rows.itemsize


@cache
def _text() -> str:
    rounds = " ".join(
        f"STEP({a}, {b}, {c}, {d}, m[{int(order[2 * k], 16)}], m[{int(order[2 * k + 1], 16)}])"
        for order in _ROUNDS
        for k, (a, b, c, d) in enumerate(_STEPS)
    )
    person = b"noctule-die".ljust(16, b"\0")
    tables = " ".join(
        f"const double {name}_[] = {{{', '.join(map(repr, values))}}};"
        for name, values in (
            ("p0", normal.P0), ("q0", normal.Q0), ("p1", normal.P1), ("q1", normal.Q1),
            ("p2", normal.P2), ("q2", normal.Q2),
        )
    )  # fmt: skip
    numbers = {
        "BEGIN8": ", ".join(f"0x{x:x}ULL" for x in _BEGIN), "ALL_ROUNDS": rounds, "TABLES": tables,
        "PERSON0": f"0x{int.from_bytes(person[:8], 'little'):x}ULL",
        "PERSON1": f"0x{int.from_bytes(person[8:], 'little'):x}ULL",
        "CELL": repr(normal.CELL), "TAIL": repr(normal.TAIL), "ROOT": repr(normal.ROOT),
        "FAR": repr(normal.FAR),
    }  # fmt: skip
    text = _TEXT
    for name, value in numbers.items():
        text = text.replace(name, value)
    return text
