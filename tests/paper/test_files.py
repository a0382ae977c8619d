"""paper/files.py, inputs.py, metrics.py and the command: what is read, what is refused."""

import subprocess
import sys

import numpy as np
import pytest

from iwis.paper.files import read_hdr, read_obj, read_probe
from iwis.paper.inputs import InputError, load_inputs
from iwis.paper.materials import FITS, table_of
from iwis.paper.metrics import error_map, mre, rank_correlation

HEAD = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n"


def _pixels():
    rgbe = np.arange(2 * 8 * 4, dtype=np.uint8).reshape(2, 8, 4)
    rgbe[..., 3] = 129
    rgbe[0, :, 0] = 7  # a run
    return rgbe


def _packed(rgbe):
    out = b""
    for row in rgbe:
        out += bytes([2, 2, 0, 8])
        for channel in row.T:
            even = len(set(channel.tolist())) == 1
            out += bytes([128 + 8, channel[0]]) if even else bytes([8, *channel.tolist()])
    return out


@pytest.mark.parametrize("pack", [_packed, lambda rgbe: rgbe.tobytes()])
def test_hdr_packed_and_plain(tmp_path, pack):
    """mantissa x 2^(e - 136), the last row of the file first."""
    path = tmp_path / "a.hdr"
    path.write_bytes(HEAD + pack(_pixels()))
    wanted = _pixels()[::-1, :, :3] * 2.0 ** (129 - 136)
    np.testing.assert_array_equal(read_hdr(path), wanted)
    assert read_probe(path).name == "a.hdr"


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"P6\n", "no Radiance picture"),
        (HEAD + _packed(_pixels())[:-3], "cut off"),
        (HEAD + b"\2\2\0\7" + bytes(60), "does not begin as a packed row"),
        (HEAD + bytes(60), "cut off"),
    ],
)
def test_bad_hdr(tmp_path, data, text):
    """One line with the path."""
    path = tmp_path / "bad.hdr"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=rf"bad\.hdr: .*{text}"):
        read_hdr(path)


def test_obj(tmp_path):
    """y up becomes z up; a square is two triangles; indices from the end count back."""
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nvn 0 0 1\nf 1//1 2//1 3//1 -1//1\n")
    mesh = read_obj(path)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.vertices[2].tolist() == [1.0, 0.0, 2.0]
    np.testing.assert_allclose(mesh.corner_normals, np.broadcast_to([0, -1, 0], (2, 3, 3)))


@pytest.mark.parametrize(
    ("text", "error"), [("v 0 0 0\n", "has no faces"), ("v 0 0 0\nf 1 2 3\n", "is not there")]
)
def test_bad_obj(tmp_path, text, error):
    """One line with the path."""
    path = tmp_path / "bad.obj"
    path.write_text(text)
    with pytest.raises(ValueError, match=rf"bad\.obj: .*{error}"):
        read_obj(path)


def test_missing_data(tmp_path):
    """Every file that is not there is named."""
    with pytest.raises(InputError, match="there is no such folder"):
        load_inputs(tmp_path / "none")
    with pytest.raises(InputError, match=r"mesh/\*\.obj"):
        load_inputs(tmp_path)
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(InputError, match=r"env: has no grace\.hdr or grace\.exr"):
        load_inputs(tmp_path)


@pytest.mark.slow
def test_command_says_what_is_missing(tmp_path):
    """Exit code 1, one line."""
    done = subprocess.run(
        [sys.executable, "-m", "iwis", "paper", "--data", tmp_path, "--out", tmp_path / "out"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("iwis: error: ")
    assert "mesh/*.obj" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_tables_of_fits_are_reciprocal():
    """Swapping both directions turns phi_d by 180 degrees: sample k is as sample -k by symmetry."""
    for fit in FITS.values():
        table = table_of(fit)
        assert np.isfinite(table).all()
        assert (table > 0.0).all()
        np.testing.assert_allclose(table[:, :, 1:90], table[:, :, :90:-1], rtol=2e-3)


def test_metrics():
    """MRE on luminance, over a mask; Spearman's rho with equal values."""
    reference, picture = np.full((2, 2, 3), 2.0), np.full((2, 2, 3), 2.0)
    picture[0, 0] = 3.0
    picture[1, 1] = 99.0
    mask = np.array([[True, True], [True, False]])
    assert error_map(picture, reference, mask).tolist() == pytest.approx(
        np.array([[0.5, 0.0], [0.0, 0.0]])
    )
    assert mre(picture, reference, mask) == pytest.approx(0.5 / 3.0)
    a = np.array([1.0, 2.0, 3.0, 4.0])
    assert rank_correlation(a, a**3) == pytest.approx(1.0)
    assert rank_correlation(a, -a) == pytest.approx(-1.0)
    assert rank_correlation(np.array([1.0, 1.0, 2.0]), np.array([1.0, 2.0, 3.0])) == pytest.approx(
        np.sqrt(0.75)
    )
