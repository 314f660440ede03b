"""Charts of made-up signals, with all kinds of curves."""

from __future__ import annotations

import numpy as np

from master.pages.chart import CIRCLE, CROSS, DOTTED, REFERENCE, Chart, Curve

ROWS = 10_000


def motions(n_curves: int = 3, rows: int = ROWS) -> Chart:
    """Oscillations with noise over a reference."""
    t = np.arange(rows) * 1e-3
    noise = np.random.default_rng(1)
    curves = [Curve("ideal", t, 10.0 * np.cos(6.0 * t), REFERENCE)]
    for k in range(n_curves):
        y = 10.0 * np.exp(0.1 * k * t) * np.cos(6.0 * t - 0.1 * k) + 0.05 * noise.standard_normal(rows)
        curves.append(Curve(f"motion {k}", t, y))
    return Chart("displacement", "time [s]", "displacement [mm]", curves, (-30.0, 30.0))


def plane() -> Chart:
    """Poles in conjugate pairs, which share their real part, and zeros."""
    poles, zeros = np.array([-0.03 + 6.1j, -0.03 - 6.1j, -2.0]), np.array([-1.0 + 5.0j, -1.0 - 5.0j])
    marks = [Curve("poles", poles.real, poles.imag, CROSS), Curve("zeros", zeros.real, zeros.imag, CIRCLE)]
    return Chart("poles and zeros", "real part [1/s]", "imaginary part [1/s]", marks)


def spectrum() -> Chart:
    """Powers of ten on both axes, a theory, and two grids."""
    f, g = np.geomspace(0.1, 500.0, 800), np.geomspace(0.2, 300.0, 70)
    lines = [
        Curve("found", f, 1e-3 / (1.0 + f)),
        Curve("expected", g, 2e-3 / (1.0 + g), DOTTED, like="found"),
    ]
    return Chart("spectrum", "frequency [Hz]", "density [N/sqrt(Hz)]", lines, logarithmic=True)


def charts() -> list[Chart]:
    """One of each kind."""
    return [motions(), plane(), spectrum()]
