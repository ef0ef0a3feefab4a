"""Writes runtime/method/tables/smg_<scheme>.h: symmetric compositions, their coefficients and the weights of their predictor.

    python tests/coefficients/compositions.py runtime/method/tables

Coefficients. One step of a symmetric method of order 2 is exp(h Y1 + h^3 Y3 + h^5 Y5 + ..), with vector fields Y_k that obey no
relation in general. A composition has order p where its product of exponentials, as a series in words of Y1, Y3, .., is that of
exp(h Y1) up to h^p. Both are exponentials of Lie series, which are known by their coefficients at Lyndon words; by the symmetry
those of odd weight suffice: 1, 1, 2, 4, 8 of weight 1, 3, 5, 7, 9. The published numbers, of 20 to 32 digits, are refined by
Newton's method on these conditions, the least change where there are fewer conditions than numbers.

Weights. Let v_i = u_i/(gamma_i h) be the increment of stage i over its size. By backward error analysis it is a series in h with
a function of the stages alone at every place: with tau the middle of the stage in time, S the sum of gamma^3 up to there (the
error so far of stages of order 2),

    1;  tau;  tau^2, gamma^2;  tau^3, tau gamma^2, S;  ...

Level l of the predictor extrapolates v from the last SPAN[l] stages with the weights of least norm that are right for all
functions of order l and below; the stages before the first are those of the step before.
"""
import itertools
import sys
import textwrap
from functools import lru_cache
from pathlib import Path

from columns import WIDTH, unformatted
from mpmath import lu_solve, matrix, mp, mpf, nstr, workdps

DIGITS = 60             # of all that is computed here, whatever mpmath is set to
SPAN = (1, 3, 6, 8)     # stages that a level looks back: some more than functions, which makes the weights small
HISTORY = max(SPAN)
LARGEST = 50            # sum of the absolute weights of v up to which a level serves; beyond it what is left out grows more than it gains

SUZUKI = "Suzuki, Fractal decomposition of exponential operators, Phys. Lett. A 146 (1990)"
KAHAN = "Kahan and Li, Composition constants for raising the orders of unconventional schemes, Math. Comp. 66 (1997)"
SOFRONIOU = "Sofroniou and Spaletta, Derivation of symmetric composition constants for symmetric integrators, Optim. Methods Softw. 20 (2005)"

# name -> (order, source, the coefficients before the middle one)
SCHEMES = {
    "suzuki5": (4, SUZUKI, ".41449077179437573714 .41449077179437573714"),
    "ss11": (6, SOFRONIOU, ".21375583945878254555518066964857 .18329381407425713911385974425217 .17692819473098943794898811709929 "
             "-.44329082681170215849622829626258 .11728560432865935385403585669136"),
    "ss13": (6, SOFRONIOU, ".13861930854051695245808013042625 .13346562851074760407046858832209 .13070531011449225190542755785015 "
             ".12961893756907034772505366537091 -.35000324893920896516170830911323 .11805530653002387170273438954049"),
    "kl9a": (6, KAHAN, ".39216144400731413928 .33259913678935943860 -.70624617255763935981 .08221359629355080023"),
    "kl17a": (8, KAHAN, ".13020248308889008087881763 .56116298177510838456196441 -.38947496264484728640807860 "
              ".15884190655515560089621075 -.39590389413323757733623154 .18453964097831570709183254 .25837438768632204729397911 "
              ".29501172360931029887096624"),
    "ss21": (8, SOFRONIOU, ".10647728984550031823931967854896 .10837408645835726397433410591546 .35337821052654342419534541324080 "
             "-.23341414023165082198780281128319 -.24445266791528841269461171413216 .11317848435755633314700952515599 "
             ".11892905625000350062692972283951 .12603912321825988140305670268365 .12581718736176041804392391641587 "
             ".11699135019217642180722881433533"),
    "ss35": (10, SOFRONIOU, ".07879572252168641926390768 .31309610341510852776481247 .02791838323507806610952027 "
             "-.22959284159390709415121340 .13096206107716486317465686 -.26973340565451071434460973 .07497334315589143566613711 "
             ".11199342399981020488957508 .36613344954622675119314812 -.39910563013603589787862981 .10308739852747107731580277 "
             ".41143087395589023782070412 -.00486636058313526176219566 -.39203335370863990644808194 .05194250296244964703718290 "
             ".05066509075992449633587434 .04967437063972987905456880"),
}
PLAIN = ("suzuki5", "ss11", "ss21", "ss35")     # of each order the one that did best

HEAD = """\
/* smidgen method: the symmetric composition {title} of {stages} stages, order {order}.
 * Written by tests/coefficients/compositions.py; do not edit.
 *
{source}
 * refined to 1e-32 by its order conditions. See Hairer, Lubich and Wanner, Geometric Numerical Integration, V.3.
 *
 *   smg_gamma[i]                  gamma_i: stage i is a step of the size gamma_i h; the sum of all is 1
 *   smg_inverse_gamma[i]          1/gamma_i, for predictions of a single sphere
 *   smg_stage_weights[i][l][j]    the predictor of level l: u_i is near the sum of these times the increments of the
 *                                 stages i - 1 - j */
#ifndef SMG_{guard}_H
#define SMG_{guard}_H

#include "smidgen.h"

#define SMG_PAIR(high, low) ((smg_real)(high) + (smg_real)(low))
"""


def words(weight):
    """Words of the letters 1, 3, 5, .. of a weight."""
    if weight == 0:
        return [()]
    return [(letter, *rest) for letter in range(1, weight + 1, 2) for rest in words(weight - letter)]


def is_lyndon(word):
    return all(word < word[k:] for k in range(1, len(word)))


def conditions(order):
    """Lyndon words of odd weight below the order, but for the letter 1, whose condition is a sum of 1."""
    return [word for weight in range(3, order, 2) for word in words(weight) if is_lyndon(word)]


def factorial(n):
    return mpf(1) if n == 0 else n * factorial(n - 1)


def product(gammas, order):
    """word -> coefficient in the product over the stages of exp(sum_k gamma^k Y_k), for weights below the order."""
    every = [word for weight in range(order) for word in words(weight)]
    found = {word: mpf(int(word == ())) for word in every}
    for g in gammas:
        powers = [g**weight for weight in range(order)]
        found = {word: sum(found[word[:k]] * powers[sum(word[k:])] / factorial(len(word) - k) for k in range(len(word) + 1))
                 for word in every}
    return found


def palindrome(half):
    """All coefficients from those before the middle one."""
    return [*half, 1 - 2 * sum(half), *reversed(half)]


@workdps(DIGITS)
def defects(half, order):
    """The order conditions: 0 where they hold."""
    found = product(palindrome(half), order)
    return [found[word] for word in conditions(order)]


def refined(half, order):
    """half, changed as little as the order conditions ask for."""
    x, width, at = list(half), mpf(10)**-30, defects(half, order)
    for _ in range(4):
        if max(abs(a) for a in at) < mpf(10)**-45:
            break
        J = matrix(len(at), len(x))
        for j in range(len(x)):
            moved = defects([y + width * (k == j) for k, y in enumerate(x)], order)
            for i, (a, b) in enumerate(zip(at, moved)):
                J[i, j] = (b - a) / width
        change = J.T * lu_solve(J * J.T, matrix(at))
        x = [a - b for a, b in zip(x, change)]
        at = defects(x, order)
    return x


@lru_cache(maxsize=None)
@workdps(DIGITS)
def coefficients(name):
    """The half list of a scheme, to all digits of mpmath."""
    order, _, given = SCHEMES[name]
    if name == "suzuki5":
        return (1 / (4 - mpf(4)**(mpf(1) / 3)),) * 2
    return tuple(refined([mpf(x) for x in given.split()], order))


def functions(tau, g, S):
    """By order: what v is made of."""
    return [[mpf(1)], [tau], [tau**2, g**2], [tau**3, tau * g**2, S]]


def stages_before(gammas, i):
    """(tau, gamma, S) of stage i and of the HISTORY ones before it, newest first, tau and S counted from stage i."""
    found, tau, S = [(mpf(0), gammas[i], mpf(0))], -gammas[i] / 2, -gammas[i]**3 / 2
    for j in range(1, HISTORY + 1):
        g = gammas[(i - j) % len(gammas)]
        found.append((tau - g / 2, g, S - g**3 / 2))
        tau, S = tau - g, S - g**3
    return found


def least_norm(A, b):
    """The x of least norm with A x = b, rows of A that depend on others left out."""
    rows, basis = [], []
    for k in range(A.rows):
        left = A[k, :]
        for v in basis:
            left = left - (left * v.T)[0] * v
        size = mp.sqrt((left * left.T)[0])
        if size > mpf(10)**-20:
            basis.append(left / size)
            rows.append(k)
    A = matrix([[A[k, j] for j in range(A.cols)] for k in rows])
    return A.T * lu_solve(A * A.T, matrix([b[k] for k in rows]))


def rate_weights(places, level):
    """Weights of v of the stages before, newest first."""
    rows = [list(itertools.chain(*functions(*place)[:level + 1])) for place in places]
    A = matrix(len(rows[0]), SPAN[level])
    for j in range(A.cols):
        for k, x in enumerate(rows[j + 1]):
            A[k, j] = x
    return least_norm(A, rows[0])


def weights(gammas, i, level):
    """Weights of the increments u of the stages before stage i, newest first: of this level, or of the next below that serves."""
    places = stages_before(gammas, i)
    x = rate_weights(places, level)
    if level > 0 and sum(abs(a) for a in x) > LARGEST:
        return weights(gammas, i, level - 1)
    return [a * gammas[i] / place[1] if abs(a) > mpf(10)**-30 else mpf(0) for a, place in zip(x, places[1:])]


def pair(x):
    high = float(x)
    return f"SMG_PAIR({high!r}, {float(x - mpf(high))!r})"


def listed(items):
    return "{\n" + ",\n".join("    " + x for x in items) + "}"


def braces(rows):
    return "{" + ", ".join(rows) + "}"


def row(x):
    return braces([nstr(a, 12, min_fixed=-4, max_fixed=12) if a else "0" for a in x] + ["0"] * (HISTORY - len(x)))


def title(name):
    return {"suzuki5": "of Suzuki"}.get(name, name.upper())


@workdps(DIGITS)
def header_of(name, order, source, half, guard=None):
    """The C header of a scheme; half: mpmath numbers, none for the scheme of one stage."""
    every, n = palindrome(half), 2 * len(half) + 1
    middle = f"1 - 2*({' + '.join(pair(x) for x in half)})" if half else "1"
    gammas = [pair(x) for x in half] + [middle] + [pair(x) for x in reversed(half)]
    table = [braces([row(weights(every, i, level)) for level in range(len(SPAN))]) for i in range(n)]
    said = textwrap.fill(f"{source};", WIDTH, initial_indent=" * ", subsequent_indent=" * ")
    numbers = (f"static const smg_real smg_gamma[{n}] = {listed(gammas)};\n"
               f"\n#if SMG_SINGLE_SPHERE\nstatic const double smg_inverse_gamma[{n}] = {listed(repr(float(1 / x)) for x in every)};\n#endif\n"
               f"\n/* {', '.join(str(x) for x in SPAN)} stages back */\n"
               f"static const double smg_stage_weights[{n}][{len(SPAN)}][{HISTORY}] = {listed(table)};\n")
    return HEAD.format(title=title(name), stages=n, order=order, source=said, guard=(guard or name).upper()) + f"\n{unformatted(numbers)}\n#endif\n"


def header(name):
    order, source, _ = SCHEMES[name]
    return header_of(name, order, source, coefficients(name))


if __name__ == "__main__":
    for scheme in SCHEMES:
        Path(sys.argv[1], f"smg_{scheme}.h").write_text(header(scheme))
