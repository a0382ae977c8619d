"""benchmarks/hot_kernels.py: what it makes of perf's report."""

import hot_kernels
import pytest


def test_time_is_told_by_kernel_and_by_library():
    mangled = "_ZN4iwis4core10lobe_cells9add_glossB3v43B134i3fLSUyHBSM8RdiC"
    assert hot_kernels.kernel_name(mangled) == "lobe_cells.add_gloss"
    report = """# a comment
    30.50%  [JIT] tid 17        [.] lobe_cells.add_gloss   -      -
    20.25%  libembree4.so.4     [.] 0x0000000002011316     -      -
    10.25%  libembree4.so.4     [.] 0x0000000002011317     -      -
     0.50%  [kernel.kallsyms]   [k] finish_task            -      -
     0.25%  perf                [.] main                   -      -
"""
    shares = hot_kernels.shares_of(report)
    expected = {"lobe_cells.add_gloss": 0.305, "Embree": 0.305, "system": 0.005, "other": 0.0025}
    assert shares == pytest.approx(expected)
    page = hot_kernels.table({"a": (1.5, shares), "b": (2.0, {"Embree": 0.5})}).splitlines()
    assert page[2] == "| CPU s a render | 1.50 | 2.00 |"
    assert page[3] == "| Embree | 30.5 | 50.0 |" and len(page) == 5
