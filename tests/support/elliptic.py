"""The free rigid body in closed form, by Jacobi's elliptic functions."""
import mpmath as mp
import numpy as np
from scipy.special import ellipj

ANGLE = 11, 10      # w(0) = (cos 1.1, 0, sin 1.1), 1.1 as a fraction: exact in any precision


def constants(moments):
    """(amplitudes of cn, sn, dn; rate lambda; parameter m) for w(0) = (c, 0, s).

    Euler's equations w' = w x I^-1 w, I_1 < I_2 < I_3, with w = (a cn, b sn, d dn)(lambda t | m):
    w_1' = w_2 w_3 (1/I_3 - 1/I_2) and so on; a = c and d = s are the start, the other three
    numbers follow by comparing coefficients of sn dn, cn dn and sn cn:
        -a lambda = b d p1,   b lambda = a d p2,   -d m lambda = a b p3.
    """
    inverse = [1 / mp.mpf(i) for i in moments]
    p1, p2, p3 = (inverse[2] - inverse[1], inverse[0] - inverse[2], inverse[1] - inverse[0])
    angle = mp.mpf(ANGLE[0]) / ANGLE[1]
    a, d = mp.cos(angle), mp.sin(angle)
    rate = d * mp.sqrt(-p1 * p2)
    b = a * d * p2 / rate
    return (a, b, d), rate, -a * b * p3 / (d * rate)


def solution(moments, t):
    """w(t), three mpmath numbers in the working precision of mpmath."""
    (a, b, d), rate, m = constants(moments)
    cn, sn, dn = (mp.ellipfun(name, rate * mp.mpf(t), m=m) for name in ("cn", "sn", "dn"))
    return a * cn, b * sn, d * dn


def period(moments):
    """The time after which w comes back."""
    _, rate, m = constants(moments)
    return 4 * mp.ellipk(m) / rate


def curve(moments, times):
    """w at many times in double precision (scipy), shape (len(times), 3)."""
    (a, b, d), rate, m = constants(moments)
    sn, cn, dn, _ = ellipj(float(rate) * np.asarray(times), float(m))
    return np.stack([float(a) * cn, float(b) * sn, float(d) * dn], axis=1)
