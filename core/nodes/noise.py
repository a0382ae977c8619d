"""The Noise Texture node: Perlin's noise in one to four dimensions and its fractal sums."""

from __future__ import annotations

import numpy as np

from .hashing import hash_numbers
from .values import as_number, as_vector, clipped, mixed, parts

_FAR = np.float32(1e5)  # beyond, Blender's noise repeats itself


def perlin(p) -> np.ndarray:
    """Signed noise, float32 (n,), of p, float32 (d, n)."""
    from ..textures.perlin import PERLIN, all_within  # kernels: the exporters load without numba

    p = np.ascontiguousarray(p, np.float32)
    if not all_within(p, _FAR):
        p = np.nan_to_num(p, posinf=0.0, neginf=0.0)
        p = np.fmod(p, _FAR) + np.float32(0.5) * (np.abs(p) >= 1000000.0)
    value = np.empty(p.shape[1], np.float32)
    PERLIN[len(p) - 1](p, value)
    return value


class _Fractal:
    """The sums of octaves. All arrays float32 (n,), p (d, n)."""

    def __init__(self, detail, roughness, lacunarity, offset, gain, normalize):
        self.detail, self.roughness, self.lacunarity = detail, roughness, lacunarity
        self.offset, self.gain, self.normalize = offset, gain, normalize
        self.whole = np.floor(detail)
        self.rest = detail - self.whole
        self.last = int(self.whole.max(initial=0.0))

    def _octaves(self, first=0):
        """(number, mask of the points that have this octave in full)."""
        for k in range(first, self.last + 1):
            yield k, k <= self.whole

    def fbm(self, p):
        scale, amplitude, most, total = 1.0, np.ones_like(self.detail), 0.0, 0.0
        final = final_most = final_scale = final_amplitude = np.zeros_like(self.detail)
        for _, here in self._octaves():
            total = total + np.where(here, perlin(scale * p) * amplitude, 0.0)
            most = most + np.where(here, amplitude, 0.0)
            amplitude = np.where(here, amplitude * self.roughness, amplitude)
            scale = np.where(here, scale * self.lacunarity, scale)
        final, final_most, final_scale, final_amplitude = total, most, scale, amplitude
        if not self.rest.any():
            return 0.5 * final / final_most + 0.5 if self.normalize else final
        more = final + perlin(final_scale * p) * final_amplitude
        if not self.normalize:
            return mixed(final, more, self.rest)
        low, high = final / final_most, more / (final_most + final_amplitude)
        return mixed(0.5 * low + 0.5, 0.5 * high + 0.5, self.rest)

    def multifractal(self, p):
        value = power = np.ones_like(self.detail)
        for _, here in self._octaves():
            value = np.where(here, value * (power * perlin(p) + 1.0), value)
            power = np.where(here, power * self.roughness, power)
            p = np.where(here, p * self.lacunarity, p)
        if self.rest.any():
            value = value * np.where(self.rest != 0.0, self.rest * power * perlin(p) + 1.0, 1.0)
        return value

    def hetero_terrain(self, p):
        power, value = self.roughness, self.offset + perlin(p)
        p = p * self.lacunarity
        for _, here in self._octaves(1):
            value = value + np.where(here, (perlin(p) + self.offset) * power * value, 0.0)
            power = np.where(here, power * self.roughness, power)
            p = np.where(here, p * self.lacunarity, p)
        return value + self.rest * (perlin(p) + self.offset) * power * value

    def hybrid(self, p):
        value, power = np.zeros_like(self.detail), np.ones_like(self.detail)
        weight = np.ones_like(self.detail)
        for _, here in self._octaves():
            here = here & (weight > 0.001)
            limited = np.minimum(weight, 1.0)
            signal = (perlin(p) + self.offset) * power
            power = np.where(here, power * self.roughness, power)
            value = value + np.where(here, limited * signal, 0.0)
            weight = np.where(here, limited * self.gain * signal, weight)
            p = np.where(here, p * self.lacunarity, p)
        signal = (perlin(p) + self.offset) * power
        more = self.rest * np.minimum(weight, 1.0) * signal
        return value + np.where((self.rest != 0.0) & (weight > 0.001), more, 0.0)

    def ridged(self, p):
        signal = (self.offset - np.abs(perlin(p))) ** 2
        value, power = signal, self.roughness
        for _, here in self._octaves(1):
            p = np.where(here, p * self.lacunarity, p)
            weight = clipped(signal * self.gain)
            new = (self.offset - np.abs(perlin(p))) ** 2 * weight
            signal = np.where(here, new, signal)
            value = value + np.where(here, signal * power, 0.0)
            power = np.where(here, power * self.roughness, power)
        return value


def fbm(p, detail, roughness, lacunarity=2.0) -> np.ndarray:
    """Fractal Brownian motion in 0 ... 1, float32 (n,), of p, float32 (d, n)."""
    n = p.shape[1]
    detail, roughness = (as_number(a, n) for a in (detail, roughness))
    return _Fractal(detail, roughness, np.float32(lacunarity), None, None, True).fbm(p)


_KINDS = {
    "FBM": _Fractal.fbm,
    "MULTIFRACTAL": _Fractal.multifractal,
    "HETERO_TERRAIN": _Fractal.hetero_terrain,
    "HYBRID_MULTIFRACTAL": _Fractal.hybrid,
    "RIDGED_MULTIFRACTAL": _Fractal.ridged,
}


def random_offset(seed: float, d: int) -> np.ndarray:
    """Where the noise of another channel begins, float32 (d, 1)."""
    seed = np.float32([seed])
    if d == 1:
        return np.float32(100.0) + hash_numbers(seed)[None] * np.float32(100.0)
    rows = [hash_numbers(seed, np.float32([k])) for k in range(d)]
    return np.float32(100.0) + np.stack(rows) * np.float32(100.0)


def noise_place(context, inputs, dimensions) -> np.ndarray:
    """float32 (d, n): where a texture of so many dimensions is looked up, not scaled yet."""
    n = len(context)
    co = inputs.get("Vector")
    x, y, z = parts(as_vector(context.generated if co is None else co, n))
    w = as_number(inputs.get("W", np.float32(0.0)), n)
    return np.stack({"1D": (w,), "2D": (x, y), "3D": (x, y, z), "4D": (x, y, z, w)}[dimensions])


def noise_texture(context, settings, inputs):
    n = len(context)
    p = noise_place(context, inputs, settings["noise_dimensions"]) * as_number(inputs["Scale"], n)
    names = ("Detail", "Roughness", "Lacunarity", "Offset", "Gain")
    detail, roughness, *rest = (as_number(inputs.get(k, np.float32(0.0)), n) for k in names)
    fractal = _Fractal(
        np.clip(detail, 0.0, 15.0), np.maximum(roughness, 0.0), *rest, settings["normalize"]
    )
    kind, d = _KINDS[settings["noise_type"]], len(p)
    distortion = as_number(inputs["Distortion"], n)
    if distortion.any():
        p = p + np.stack([perlin(p + random_offset(k, d)) for k in range(d)]) * distortion
    value = kind(fractal, p)
    outputs = {"Fac": value}
    if "Color" in settings["outputs"]:
        more = [kind(fractal, p + random_offset(k, d)) for k in (d, d + 1)]
        outputs["Color"] = np.stack([value, *more], -1)
    return outputs


FUNCTIONS = {"ShaderNodeTexNoise": noise_texture}
