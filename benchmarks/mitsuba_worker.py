"""Mitsuba 3 on a scene that run_mitsuba.py wrote: a process that renders what it is told.

    VENV/bin/python benchmarks/mitsuba_worker.py SCENE.npz THREADS

Run by a Python that has mitsuba, which need not be the one with bpy. Reads one JSON object a line,
{"samples", "seed", "emitter", "bsdf", "path"}; writes the picture to path (.npy, float32 (h, w, 3),
row 0 at the bottom) and answers {"cpu", "wall", "samples"} in a line. The first line that it writes
is {"version", "cpu"}: the CPU seconds of loading.

Direct light as Cycles with no bounces and IWIS: primary rays through pixel centres, the integrator
"direct". Multi-jittered samples: with "independent" ones Mitsuba needs several times as many.
"""

from __future__ import annotations

import ctypes.util
import glob
import json
import os
import resource
import sys
import time

import numpy as np

POINTS_AT_ONCE = (
    8_000_000  # a wavefront: 64 samples of 200x400 in four took 1.2 times, in 16 1.6 times
)


def cpu_seconds() -> float:
    """User + system time of this process, all threads."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def find_llvm() -> None:
    """Tell Dr.Jit where LLVM is: it looks for libLLVM.so only, which Debian does not install."""
    if "DRJIT_LIBLLVM_PATH" in os.environ or ctypes.util.find_library("LLVM"):
        return
    found = glob.glob("/usr/lib/*/libLLVM-*.so*") + glob.glob("/usr/lib/*/libLLVM.so.*")
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = max(found, key=_llvm_version)


def _llvm_version(path: str) -> int:
    digits = path.rpartition("libLLVM")[2].lstrip("-.so").split(".")[0]
    return int(digits) if digits.isdigit() else 0


def mesh_of(mi, data, k):
    """Mesh k of the file as a Mitsuba shape, with its BSDF."""
    vertices, faces = data[f"vertices{k}"], data[f"faces{k}"]
    normals = data[f"normals{k}"] if f"normals{k}" in data else None
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(json.loads(str(data[f"bsdf{k}"])))
    properties["face_normals"] = normals is None
    mesh = mi.Mesh(
        f"mesh{k}",
        len(vertices),
        len(faces),
        has_vertex_normals=normals is not None,
        props=properties,
    )
    params = mi.traverse(mesh)
    params["vertex_positions"] = vertices.ravel()
    params["faces"] = faces.ravel()
    if normals is not None:
        params["vertex_normals"] = normals.ravel()
    params.update()
    return mesh


def envmap(mi, data):
    """The HDRI. Mitsuba's own map is y up, its first row looks up, and it runs the other way."""
    turn = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]) @ data["world_to_map"]
    to_world = np.eye(4)
    to_world[:3, :3] = turn.T
    bitmap = mi.Bitmap(np.ascontiguousarray(data["radiance"][::-1]))
    return {
        "type": "envmap",
        "bitmap": bitmap,
        "to_world": mi.ScalarTransform4f(to_world),
    }


class Renderer:
    """The loaded scene, and a direct integrator for each pair of sample counts."""

    def __init__(self, mi, dr, data):
        self._mi, self._dr = mi, dr
        meshes = {f"mesh{k}": mesh_of(mi, data, k) for k in range(int(data["meshes"]))}
        self._scene = mi.load_dict({"type": "scene", "environment": envmap(mi, data), **meshes})
        self._integrators, self._warm = {}, set()
        self._width, self._height = (int(n) for n in data["size"])
        self._matrix, self._window = data["camera_to_world"], data["window"]
        self._near = float(data["clip_start"])

    def warm(self, samples: int, emitter: int, bsdf: int, **_) -> None:
        """Have the kernels of a render compiled: two wavefronts of it, once."""
        if (samples, emitter, bsdf) not in self._warm:
            self._warm.add((samples, emitter, bsdf))
            self.render(samples, 0, emitter, bsdf, most=2)

    def render(self, samples: int, seed: int, emitter: int, bsdf: int, most=None) -> np.ndarray:
        """float32 (h, w, 3), row 0 at the bottom; samples: a square, of camera paths.

        most: wavefronts after which to stop
        """
        mi, dr = self._mi, self._dr
        n = self._width * self._height
        divisors = [k for k in range(1, samples + 1) if samples % k == 0]
        at_once = max(k for k in divisors if k == 1 or k * n <= POINTS_AT_ONCE)
        sampler = mi.load_dict({"type": "multijitter", "sample_count": samples})
        sampler.set_samples_per_wavefront(at_once)
        sampler.seed(seed, n * at_once)
        ray = self._rays(dr.arange(mi.UInt32, n * at_once) // dr.opaque(mi.UInt32, at_once))
        integrator = self._integrator(emitter, bsdf)
        total = None
        for _ in range(min(samples // at_once, most or samples)):
            light, _, _ = integrator.sample(self._scene, sampler, ray)
            dr.eval(light)  # a lazy one would be traced once a channel
            parts = [dr.block_sum(c, at_once) for c in (light.x, light.y, light.z)]
            total = parts if total is None else [a + b for a, b in zip(total, parts, strict=True)]
            sampler.advance()
            sampler.schedule_state()
            dr.eval(total)
        rgb = np.stack([np.array(channel) for channel in total], -1) / samples
        return rgb.reshape(self._height, self._width, 3).astype(np.float32)

    def _rays(self, pixel):
        mi, dr = self._mi, self._dr
        left, right, bottom, top = (float(edge) for edge in self._window)
        row = pixel // self._width
        column = pixel - row * self._width
        x = left + (right - left) * ((mi.Float(column) + 0.5) / self._width)
        y = bottom + (top - bottom) * ((mi.Float(row) + 0.5) / self._height)
        m = self._matrix
        direction = mi.Vector3f(
            *(float(m[a, 0]) * x + float(m[a, 1]) * y - m[a, 2] for a in range(3))
        )
        direction = dr.normalize(direction)
        origin = mi.Point3f(*(float(m[a, 3]) for a in range(3))) + self._near * direction
        dr.eval(origin, direction)
        return mi.RayDifferential3f(mi.Ray3f(origin, direction))

    def _integrator(self, emitter, bsdf):
        key = emitter, bsdf
        if key not in self._integrators:
            self._integrators[key] = self._mi.load_dict(
                {"type": "direct", "emitter_samples": emitter, "bsdf_samples": bsdf}
            )
        return self._integrators[key]


def main() -> None:
    """Load, say so, then answer until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what Mitsuba prints is no answer
    find_llvm()
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(int(sys.argv[2]))
    before = cpu_seconds()
    with np.load(sys.argv[1]) as data:
        renderer = Renderer(mi, dr, data)
    print(json.dumps({"version": mi.__version__, "cpu": cpu_seconds() - before}), file=answers)
    for line in sys.stdin:
        order = json.loads(line)
        path = order.pop("path")
        renderer.warm(**order)
        wall, cpu = time.perf_counter(), cpu_seconds()
        rgb = renderer.render(**order)
        cost = {"cpu": cpu_seconds() - cpu, "wall": time.perf_counter() - wall}
        np.save(path, rgb)
        print(json.dumps(cost | {"samples": order["samples"]}), file=answers)


if __name__ == "__main__":
    main()
