"""Hold sampled steps (`bench samples N | check.py`) against the step equation solved in 40 digits.

A component of W may be off by one unit in its last place (its own rounding and the carry) and by four units
of the increment u_i (the roundings of m, of the products and of the scale).  Per design: the largest error in
units of that bound, and the largest error itself.  Exits 1 where the bound is broken.
"""
import sys

from mpmath import mp, mpf, norm

mp.dps = 40
H, INVERSE = mpf(0.1), [mpf(1), mpf(1) / 2, mpf(1) / 4]


def cross(a, b):
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def step(w):
    """W of W - w = h m x I^-1 m, m = (w + W)/|w + W|, by fixed point to 40 digits."""
    u = [mpf(0)] * 3
    for _ in range(60):
        s = [2 * a + b for a, b in zip(w, u)]
        m = [x / norm(s) for x in s]
        u = [H * x for x in cross(m, [a * x for a, x in zip(INVERSE, m)])]
    return [a + b for a, b in zip(w, u)]


def unit(x):
    """One unit in the last place of the double next to x."""
    return mpf(2) ** (mp.frexp(abs(x))[1] - 53)


def errors(values):
    before, after = [mpf(v) for v in values[:3]], [mpf(v) for v in values[3:]]
    exact = step(before)
    return [(abs(a - e), unit(a) + 4 * unit(e - b)) for a, e, b in zip(after, exact, before)]


def main():
    worst = {}
    for line in sys.stdin:
        name, *numbers = line.split(",")
        pairs = errors([float(x) for x in numbers])
        ratio, size = worst.get(name, (0, 0))
        worst[name] = max(ratio, *(e / u for e, u in pairs)), max(size, *(e for e, _ in pairs))
    print("design,largest error / bound,largest error")
    for name, (ratio, size) in worst.items():
        print(f"{name},{float(ratio):.2f},{float(size):.2e}")
    return int(not worst or max(ratio for ratio, _ in worst.values()) > 1)


if __name__ == "__main__":
    sys.exit(main())
