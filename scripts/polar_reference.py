"""Reference numbers of the paper's equation (4) (docs/model.md, section 4) for tests/theory.rs, to 25 digits.

Turning points by a root of the two half-fold integrals; the integrals by Gauss-Legendre quadrature after r = r1 + x^2 and r = r2 - x^2,
so that nothing of the crate's substitution is shared.   Made with Python 3.11, mpmath 1.4.   usage: polar_reference.py
"""
from mpmath import mp, mpf, sqrt, quad, findroot, pi

mp.dps = 30  # the root and the integrals then agree to 20 digits and more
WAIST, SLANT = mpf("0.121"), mpf("0.53")


def G(r, weight, foundation):
    return weight * (SLANT - sqrt(SLANT**2 - (r - WAIST) ** 2)) + foundation / 2 * (WAIST - r) ** 2


def half_fold(r1, r2, weight, foundation):
    """Angle, length, lambda and C of half a fold."""
    g1, g2 = G(r1, weight, foundation), G(r2, weight, foundation)
    lam = (g2 - g1) / (r2 - r1)
    C = g1 - lam * r1

    def integrand(f):
        # r = r1 + x^2 and r = r2 - x^2 on the two halves take the square roots out of the endpoints.
        top = sqrt((r2 - r1) / 2)

        def value(r, gap_at, gap):
            A = G(r, weight, foundation) - C
            # lam r - A vanishes at both ends: form it from the near end by differences of G.
            near = lam * (r - gap_at) - (G(r, weight, foundation) - G(gap_at, weight, foundation))
            return f(r, A) / sqrt(near * (lam * r + A)) * 2 * gap

        return quad(lambda x: value(r1 + x * x, r1, x), [0, top], method="gauss-legendre") + quad(lambda x: value(r2 - x * x, r2, x), [0, top], method="gauss-legendre")

    return integrand(lambda r, A: A / r), integrand(lambda r, A: lam * r), lam, C


if __name__ == "__main__":
    for m, R, weight, foundation, start in [
        (5, "0.1452", "1.962", 0, (0.107, 0.147)),
        (8, "0.1452", "1.962", 0, (0.110, 0.137)),
        (5, "0.1452", "1.962", 20, (0.107, 0.147)),
        (8, "0.2362", "1.962", 0, (0.092, 0.160)),
    ]:
        w, E = mpf(weight), mpf(foundation)
        r1, r2 = findroot(lambda a, b: [half_fold(a, b, w, E)[0] - pi / m, half_fold(a, b, w, E)[1] - pi * mpf(R) / m], start, tol=1e-20, maxsteps=40)
        _, _, lam, C = half_fold(r1, r2, w, E)
        print(m, R, weight, foundation, *(mp.nstr(x, 14) for x in (r1, r2, lam, C)))
    for m, start in [(4, (0.070, 0.209)), (5, (0.077, 0.190)), (8, (0.0915, 0.1600))]:
        w = mpf("1.962")
        r1, r2 = findroot(lambda a, b: [half_fold(a, b, w, 0)[0] - pi / m, half_fold(a, b, w, 0)[3]], start, tol=1e-20, maxsteps=40)
        print("limit", m, mp.nstr(half_fold(r1, r2, w, 0)[1] * m / pi / WAIST, 12))
