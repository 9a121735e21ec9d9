"""An elastic layer bonded to a rigid base: what its surface does under tractions, exactly, by Fourier transforms.

Papkovich and Neuber's solution: 2 G u = grad(phi + z psi) - 4 (1 - nu) psi e_z with harmonic phi and psi for what lies in the plane of a
wave, and shear alone across it.
"""
import numpy as np


def surface_moves(traction, pitch, thickness, young, poisson):
    """Displacements (ux, uy, uz) of the surface, mm, under tractions (tx, ty, p), MPa, of square cells: arrays n x n x 3, periodic."""
    shear = young / (2 * (1 + poisson))
    lame = 2 * shear * poisson / (1 - 2 * poisson)
    n = traction.shape[0]
    wave = 2 * np.pi * np.fft.fftfreq(n, pitch)
    kx, ky = np.meshgrid(wave, wave, indexing="ij")
    k = np.hypot(kx, ky)
    k[0, 0] = 1  # done apart
    tx, ty, p = (np.fft.fft2(traction[:, :, axis]) for axis in range(3))
    cos, sin = kx / k, ky / k
    along, across = cos * tx + sin * ty, cos * ty - sin * tx

    flat = k.ravel()
    turn = 3 - 4 * poisson

    def parts(z):
        """Of the four solutions: displacement along (over i) and up, and their slopes by z."""
        up, down = np.exp(flat * z), np.exp(-flat * (z + thickness))
        u = [up, z * up, down, z * down]
        w = [up, z * up - turn * up / flat, -down, -z * down - turn * down / flat]
        du = [flat * up, (1 + flat * z) * up, -flat * down, (1 - flat * z) * down]
        dw = [flat * up, (1 + flat * z - turn) * up, flat * down, (-1 + flat * z + turn) * down]
        return (np.array(each).T for each in (u, w, du, dw))

    u, w, du, dw = parts(0)
    base_u, base_w, _, _ = parts(-thickness)
    column = flat[:, None]
    system = np.stack([shear * (du + column * w), lame * (dw - column * u) + 2 * shear * dw, base_u, base_w], axis=1)
    given = np.zeros((flat.size, 4), complex)
    given[:, 0], given[:, 1] = along.ravel() / 1j, -p.ravel()
    shares = np.linalg.solve(system, given[:, :, None])[:, :, 0]
    moved_along = 1j * np.sum(shares * u, axis=1).reshape(k.shape)
    moved_up = np.sum(shares * w, axis=1).reshape(k.shape)
    moved_across = np.tanh(k * thickness) / (shear * k) * across
    moved = [cos * moved_along - sin * moved_across, sin * moved_along + cos * moved_across, moved_up]
    moved[0][0, 0], moved[1][0, 0] = thickness / shear * tx[0, 0], thickness / shear * ty[0, 0]
    moved[2][0, 0] = -p[0, 0] * thickness / (lame + 2 * shear)
    return np.stack([np.fft.ifft2(each).real for each in moved], axis=2)


def around(cells, count):
    """The cells in the middle of so many along each side, nothing around them."""
    wide = np.zeros((count, count, cells.shape[2]))
    first = (count - cells.shape[0]) // 2
    wide[first:first + cells.shape[0], first:first + cells.shape[1]] = cells
    return wide


def middle(wide, count):
    first = (wide.shape[0] - count) // 2
    return wide[first:first + count, first:first + count]
