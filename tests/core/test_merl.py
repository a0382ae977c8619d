"""core/bsdf/merl.py: MERL's format, and the value between its samples."""

import numpy as np
import pytest

from iwis.core._jit import kernel
from iwis.core.bsdf.merl import FILE_BYTES, eval_merl, read_merl
from support.merl import SIDES, eval_table, glossy_table, lambert_table, lifted, write_merl


@kernel
def _eval_all(tables, normal, wo, wi, out):
    n = (normal[0], normal[1], normal[2])
    for k in range(len(wi)):
        o, i = (wo[k, 0], wo[k, 1], wo[k, 2]), (wi[k, 0], wi[k, 1], wi[k, 2])
        out[k, 0], out[k, 1], out[k, 2] = eval_merl(tables, 0, n, o, i)


def _values(table, wo, wi, normal=(0, 0, 1)):
    out = np.empty((len(wi), 3), np.float32)
    arrays = (np.ascontiguousarray(a, np.float32) for a in (normal, wo, wi))
    _eval_all(np.ascontiguousarray(table[None]), *arrays, out)
    return out


def _above(rng, n):
    """Unit vectors with z > .05, float32 (n, 3)."""
    v = rng.normal(size=(4 * n, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    return v[v[:, 2] > 0.05][:n].astype(np.float32)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write_merl(tmp_path_factory.mktemp("merl") / "glossy.binary", glossy_table())


def test_values_and_scales_are_the_files(file):
    """Every defined sample, all three channels; the hash is of the bytes."""
    values, digest = read_merl(file)
    assert values.shape == (*SIDES, 3)
    assert values.dtype == np.float32
    np.testing.assert_allclose(values[lifted()], glossy_table()[lifted()], rtol=1e-6)
    assert len(digest) == 64
    assert digest == read_merl(file)[1]


def test_undefined_samples_stand_for_their_neighbour(file):
    """Where the file is negative: the last defined sample of smaller theta_d."""
    values, _ = read_merl(file)
    known = lifted()
    i, j, k = (a[0] for a in np.nonzero(~known & np.roll(known, 1, axis=1)))
    assert j > 0
    np.testing.assert_array_equal(values[i, j, k], values[i, j - 1, k])
    assert (values >= 0.0).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: b"", "shorter than its header"),
        (lambda data: data[:7], "7 bytes, shorter than its header"),
        (lambda data: data[: len(data) // 2], f"is cut off: {FILE_BYTES // 2} bytes of"),
        (lambda data: data + b"x", "is too long for a MERL table"),
        (lambda data: data[::-1], "its header says"),
        (lambda data: np.int32([64, 64, 64]).tobytes() + data[12:], "header says 64 x 64 x 64"),
        (lambda data: data[:-8] + np.float64([np.nan]).tobytes(), "infinite or no numbers"),
        (lambda data: data[:12] + np.full(3 * 90 * 90 * 180, -1.0).tobytes(), "no defined value"),
    ],
)
def test_damaged_files_are_refused_by_name(change, message, file, tmp_path):
    """One message: which file, what is wrong."""
    path = tmp_path / "bad.binary"
    path.write_bytes(change(file.read_bytes()))
    with pytest.raises(ValueError, match=rf"bad\.binary: .*{message}"):
        read_merl(path)


def test_missing_file_and_folder_are_refused_by_name(tmp_path):
    """As any other input."""
    with pytest.raises(FileNotFoundError, match=r"no\.binary: there is no such file"):
        read_merl(tmp_path / "no.binary")
    with pytest.raises(OSError, match="cannot be read"):
        read_merl(tmp_path)


def test_eval_is_the_naive_readers(rng):
    """By turning vectors in float64, a table of noise, random directions.

    5e-3 of the mean: float32 angles are off by 1e-5 of a sample near h = n, where theta_h's root
    makes 4e-3 of that, and neighbours of the noise differ by as much as the mean.
    """
    table = np.float32(rng.random((*SIDES, 3)))
    wo, wi = _above(rng, 4000), _above(rng, 4000)
    np.testing.assert_allclose(_values(table, wo, wi), eval_table(table, wo, wi), atol=5e-3)


def test_eval_turns_with_the_normal(rng):
    """Isotropic: a frame turned as a whole changes nothing."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    table, wo, wi = glossy_table(), _above(rng, 500), _above(rng, 500)
    turned = _values(table, wo @ turn.T, wi @ turn.T, turn @ (0.0, 0.0, 1.0))
    # 1e-3: the turned float32 vectors are off by 1e-7, their theta_h near 0 by its root.
    np.testing.assert_allclose(turned, _values(table, wo, wi), rtol=1e-3, atol=1e-4)


def test_eval_is_reciprocal(rng):
    """wi and wo may be swapped: any table, for phi_d repeats after half a turn. float32 angles."""
    table = np.float32(rng.random((*SIDES, 3)))
    wo, wi = _above(rng, 2000), _above(rng, 2000)
    np.testing.assert_allclose(_values(table, wo, wi), _values(table, wi, wo), atol=5e-3)


def test_mirror_direction_reads_the_first_sample():
    """wi = wo mirrored: theta_h = 0, without a division by its sine."""
    cosines = np.linspace(0.05, 1.0, 20)
    wo = np.stack([np.sqrt(1.0 - cosines**2), 0.0 * cosines, cosines], -1)
    table = lambert_table() * (1.0 + np.arange(90, dtype=np.float32))[:, None, None, None]
    values = _values(table, wo, wo * (-1.0, 1.0, 1.0))
    np.testing.assert_allclose(values, table[0, 0, 0] * np.ones((20, 1)), rtol=0.05)
