"""Torque-free rotations to 40 digits, for the claim exact-rotation. Needs mpmath; takes some minutes:

    python3 exact_rotation_reference.py > exact_rotation.csv

Nothing of the closed form is used: Euler's equations and the quaternion's,

    dl/dt = l x (J^-1 l),    dq/dt = q (0, J^-1 l) / 2,    l = q^-1 L q,

are summed as Taylor series in time over short steps. Inputs are doubles, written so that they read back exactly; the
reference works on those doubles, its quaternion first normalised. The end is rounded to doubles.
"""

import math
import random
from multiprocessing import Pool

from mpmath import mp, mpf

DIGITS, ORDER, LARGEST_TURN = 40, 60, 0.4
DT = 1 / 30
TURNS = (0.01, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0)


def cross_terms(a, b, n):
    """Coefficient n of the product of two series."""
    return mp.fdot(zip(a[: n + 1], b[n::-1]))


def to_body(q, vector):
    x, y, z, w = q
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
    )
    return [mp.fdot(zip(row, vector)) for row in rows]


def normalized(q):
    length = mp.sqrt(mp.fdot(zip(q, q)))
    return [component / length for component in q]


def rotate(q, momentum, inverse_moments, dt):
    """Orientation (x, y, z, w) after dt."""
    mp.dps = DIGITS
    q = normalized([mpf(v) for v in q])
    momentum = [mpf(v) for v in momentum]
    rate = [mpf(v) for v in inverse_moments]
    fastest = max(rate) * mp.sqrt(mp.fdot(zip(momentum, momentum)))
    steps = int(mp.ceil(fastest * mpf(dt) / LARGEST_TURN))
    h = mpf(dt) / steps
    for _ in range(steps):
        l = [[v] for v in to_body(q, momentum)]
        x, y, z, w = ([v] for v in q)
        for n in range(ORDER):
            u = [[rate[i] * v for v in l[i]] for i in range(3)]
            # l is constant in the world, so its series follows from Euler's equations alone.
            new_l = [
                (rate[k] - rate[j]) * cross_terms(l[j], l[k], n) / (n + 1)
                for i in range(3)
                for j, k in [((i + 1) % 3, (i + 2) % 3)]
            ]
            half = mpf(1) / (2 * (n + 1))

            def term(a, axis):
                return cross_terms(a, u[axis], n)

            new_q = (
                half * (term(w, 0) + term(y, 2) - term(z, 1)),
                half * (term(w, 1) + term(z, 0) - term(x, 2)),
                half * (term(w, 2) + term(x, 1) - term(y, 0)),
                -half * (term(x, 0) + term(y, 1) + term(z, 2)),
            )
            for series, value in zip((*l, x, y, z, w), (*new_l, *new_q)):
                series.append(value)
        q = normalized([mp.polyval(series[::-1], h) for series in (x, y, z, w)])
    return [float(v) for v in q]


def box(a, b, c):
    """Inverse moments of a solid box of 3 kg."""
    return [1 / (b * b + c * c), 1 / (c * c + a * a), 1 / (a * a + b * b)]


def direction(rng):
    while True:
        v = [rng.uniform(-1, 1) for _ in range(3)]
        length = math.hypot(*v)
        if 0.1 < length < 1:
            return [c / length for c in v]


def cases():
    rng = random.Random(2009)
    for turn in TURNS:
        def extent(low, high):
            return math.exp(rng.uniform(math.log(low), math.log(high)))

        for kind, inverse in (
            ("brick", box(extent(0.3, 1), extent(0.3, 1), extent(0.3, 1))),
            ("brick", box(extent(0.1, 1), extent(0.1, 1), extent(0.1, 1))),
            ("brick", [1 / m for m in (2.5, 1.0, 2.0)]),
            ("rod", box(1, extent(0.01, 0.05), extent(0.01, 0.05))),
            ("rod", box(extent(0.02, 0.1), extent(0.02, 0.1), 1)),
            ("plate", box(1, extent(0.3, 1), 0.001)),
            ("near_symmetric", [1 / m for m in (1, 1 + 1e-7, 0.3)]),
            ("near_symmetric", [1 / m for m in (1.7, 1, 1 + 1e-9)]),
            ("near_symmetric", [1 / m for m in (1, 1 + 1e-12, 1 - 1e-9)]),
            ("near_separatrix", box(0.5, 1, 0.7)),
            ("near_separatrix", box(0.1, 0.3, 1)),
        ):
            q = [float(v) for v in normalized([mpf(rng.gauss(0, 1)) for _ in range(4)])]
            l = direction(rng)
            if kind == "near_separatrix":
                # Off the intermediate axis by up to 3 %.
                middle = sorted(range(3), key=inverse.__getitem__)[1]
                l = [0.03 * v for v in l]
                l[middle] = 1.0
            scale = turn / (DT * math.hypot(*(i * v for i, v in zip(inverse, l))))
            x, y, z, w = q
            momentum = [scale * float(v) for v in to_body((-x, -y, -z, w), l)]
            yield kind, turn, (*q, *momentum, *inverse)


def row(case):
    kind, turn, inputs = case
    end = rotate(inputs[:4], inputs[4:7], inputs[7:], DT)
    return ",".join([kind, repr(turn), *(repr(v) for v in (*inputs, DT, *end))])


if __name__ == "__main__":
    print("kind,turn,qx,qy,qz,qw,lx,ly,lz,inverse_x,inverse_y,inverse_z,dt,end_x,end_y,end_z,end_w")
    with Pool() as pool:
        for line in pool.imap(row, cases()):
            print(line, flush=True)
