"""Reference numbers of the ruled shell (docs/model.md, section 5) for tests/theory.rs: slow, and independent of the crate.

Hem by FFT, every ring's curvature by spectral differentiation, Gauss-Legendre down the slant; BFGS from one harmonic upward, then a root of the
five-point gradient, because where BFGS stops the energy is right (it is stationary) but its split into terms is only half as good.

Made with Python 3.11+, numpy 2, scipy 1.16.   usage: ruled_reference.py [--folds 5] [--harmonics 1,2,4,8,12] [--polish] [--waist … SI units]
"""
import argparse
import numpy as np
from scipy.optimize import minimize, root


def terms(a, m, waist, hem, slant, weight, rigidity, nodes, slices):
    """Gravity, bending (J) and the radii at the nodes of one fold."""
    sigma = 2 * np.pi / m * np.arange(nodes) / nodes
    modes = np.fft.fftfreq(nodes, 1 / nodes) * m
    psi = sum(c * np.sin((k + 1) * m * sigma) for k, c in enumerate(a))
    turn = lambda f: np.fft.ifft(np.fft.fft(f) * 1j * (modes + 1))  # d/d sigma of f e^{i sigma}, times e^{-i sigma}
    h = np.fft.ifft(np.fft.fft(hem * np.exp(1j * psi)) / (1 + modes))
    d = h - waist
    if np.abs(d).max() >= slant:
        return np.inf, np.inf, np.abs(h)
    rise = slant - np.sqrt(slant**2 - np.abs(d) ** 2)
    gravity = weight * slant * (waist / 2 + (hem - waist) / 3) * 2 * np.pi * rise.mean()
    bending = 0.0
    x, w = np.polynomial.legendre.leggauss(slices)
    for u, w in zip((x + 1) / 2, w / 2):
        first = turn(waist + u * d)
        second = turn(first)
        kappa = np.imag(np.conj(first) * second) / np.abs(first) ** 3
        bending += w * rigidity / 2 * (waist + u * (hem - waist)) * slant * 2 * np.pi * np.mean(kappa**2)
    return gravity, bending, np.abs(h)


def gradient(f, a, step=1e-4):
    """Five-point differences: step^4 truncation against rounding of eps/step."""
    out = []
    for e in np.eye(len(a)) * step:
        out.append((8 * (f(a + e) - f(a - e)) - (f(a + 2 * e) - f(a - 2 * e))) / (12 * step))
    return np.array(out)


if __name__ == "__main__":
    p = argparse.ArgumentParser()
    for name, value in dict(waist=0.121, hem=0.2362, slant=0.53, density=0.2, rigidity=1e-5, gravity=9.81).items():
        p.add_argument("--" + name, type=float, default=value)
    p.add_argument("--folds", type=int, default=5)
    p.add_argument("--harmonics", default="1,2,4,8,12")
    p.add_argument("--polish", action="store_true")
    o = p.parse_args()
    scene = (o.folds, o.waist, o.hem, o.slant, o.density * o.gravity, o.rigidity)
    a = np.array([1.0])
    for k in map(int, o.harmonics.split(",")):
        nodes, slices = max(128, 16 * k), 24
        scale = o.density * o.gravity * o.slant**2 * o.hem * 0.05
        f = lambda a: sum(terms(a, *scene, nodes, slices)[:2]) / scale
        a = minimize(f, np.append(a, np.zeros(k - len(a))), method="BFGS", options=dict(gtol=1e-9, maxiter=2000)).x
        if o.polish:
            nodes, slices = 512, 48
            a = root(lambda a: gradient(f, a), a, tol=1e-13).x
        gravity, bending, r = terms(a, *scene, nodes, slices)
        print(f"K {k:2d}  U {gravity + bending:.15f}  gravity {gravity:.15f}  bending {bending:.15f}  r {r.min():.8f} .. {r.max():.8f}", np.round(a[:4], 8))
