"""What preparing a map of 8192 by 4096 texels may cost, measured in a process of its own."""

import json
import subprocess
import sys

import pytest

_SCRIPT = """
import json, sys, time
import numpy as np
from iwis.core.render_cache import RenderCache
from iwis.core.scene import EnvironmentMap
from iwis.core.stats import peak_memory_bytes

def world(height):
    rng, texels = np.random.default_rng(1), np.empty((height, 2 * height, 3), np.float32)
    for row in texels:
        row[:] = np.exp(rng.standard_normal(row.shape, np.float32))
    return EnvironmentMap(radiance=texels)

RenderCache().light(world(512), sys.argv[1])  # kernels are compiled or read
big = world(4096)
costs = []
for _ in range(2):
    before, started = peak_memory_bytes(), time.process_time()
    RenderCache().light(big, sys.argv[1])
    costs.append([time.process_time() - started, (peak_memory_bytes() - before) / 1e6])
print(json.dumps(costs))
"""


@pytest.mark.slow
def test_an_8k_map_is_prepared_in_time_and_memory(tmp_path):
    """Every texel noise, the worst there is: under 3 s of CPU, and 200 MB beside its 400 MB.

    Out of the cache folder, in the next render: under 1 s, which is the hash of its pixels.
    """
    run = subprocess.run(
        [sys.executable, "-c", _SCRIPT, str(tmp_path)], capture_output=True, text=True, check=True
    )
    (built, found) = json.loads(run.stdout.splitlines()[-1])
    assert built[0] < 3.0 and built[1] < 200.0
    assert found[0] < 1.0
