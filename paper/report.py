"""paper.html: the figures, the numbers, what is to be said of each claim; paper.json: all data."""

from __future__ import annotations

import html
import json
from pathlib import Path

from .claims import claims, numbers
from .results import MAIN, Results

_CAPTIONS = {
    "figure1": "Figure 1. e_i, e_d and sigma_d at {map_samples} samples a pixel, one colour scale "
    "(sigma_d, a radiance, scaled to the mean of e_d); e_i against the tables' reference.",
    "figure2": "Figure 2. Halton points and where the product takes them. Red: the first n, green "
    "those of 2n, blue those of 3n. Grey: the product, logarithmic, in the hemisphere's square.",
    "figure3": "Figure 3. Three pixels, from unoccluded to occluded: visible samples red, occluded "
    "ones blue.",
    "figure4": "Figure 4. E = .1, MAX = 100: pictures and samples a pixel.",
    "figure5": "Figure 5. MRE against mean samples a pixel of the object.",
    "figure5_crops": "Figure 5, crops of head and feet.",
    "tables": "The errors of tables and sampling, by the share of coefficients that is kept.",
}
_STYLE = """body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }
img { max-width: 100% } table { border-collapse: collapse } td, th { border: 1px solid #aaa;
padding: .3em .6em; text-align: left; vertical-align: top } figcaption { color: #444 }
figure { margin: 1.5em 0 }"""


def write(results: Results, pictures: dict[str, Path], folder: Path) -> Path:
    """Write both files; returns the page's path. pictures: of plots.draw_all, may be empty."""
    (folder / "paper.json").write_text(json.dumps(data_of(results), indent=1) + "\n")
    page = folder / "paper.html"
    page.write_text("\n".join(_lines(results, pictures)) + "\n", encoding="utf-8")
    return page


def data_of(results: Results) -> dict:
    """What is in the page, as plain values."""
    return {
        "source": results.inputs.source,
        "is_paper": results.inputs.is_paper,
        "plan": results.plan._asdict(),
        "seconds": results.seconds,
        "numbers": [n._asdict() for n in numbers(results)],
        "claims": [c._asdict() for c in claims(results)],
        "curves": {k: [p._asdict() for p in v] for k, v in results.curves.curves.items()},
        "tables": [t._asdict() for t in results.tables],
        "rendered": [
            {"material": r.pair.material, "probe": r.pair.probe}
            | {k: v for k, v in r._asdict().items() if k not in ("pair", "picture")}
            | {"seconds": r.picture.seconds, "cpu_seconds": r.picture.cpu_seconds}
            for r in results.rendered
        ],
        "pixels": [
            {"pixel": p.pixel, "samples": len(p.seen), "visible": int(p.seen.sum())}
            for p in results.pixels
        ],
    }


def _lines(results, pictures):
    told = html.escape
    main = results.rendered[MAIN].pair
    yield f"<!doctype html><html lang='en'><meta charset='utf-8'><style>{_STYLE}</style>"
    yield "<title>Huang et al. 2007, reproduced</title>"
    yield "<h1>Incremental Wavelet Importance Sampling, reproduced</h1>"
    yield f"<p>Made from {told(results.inputs.source)}. "
    if not results.inputs.is_paper:
        yield (
            "<strong>This is not the paper's data:</strong> materials are small fits and probes "
            "CC0 panoramas that come with IWIS; call the command with --data for the paper's own. "
        )
    yield (
        f"Figures 1, 2, 3 and 5 are of {told(main.material)} / {told(main.probe)}. References have "
        f"{results.plan.truth} samples a pixel: the true one by mode UNBIASED, the one that the "
        f"tables limit by mode PAPER. All took {results.seconds:.0f} s.</p>"
    )
    for name, path in pictures.items():
        caption = told(_CAPTIONS[name].format(**results.plan._asdict()))
        yield f"<figure><img src='{told(path.name)}' alt='{caption}'>"
        yield f"<figcaption>{caption}</figcaption></figure>"
    yield "<h2>Numbers</h2><table><tr><th></th><th>The paper</th><th>Here</th></tr>"
    for row in numbers(results):
        yield "<tr>" + "".join(f"<td>{told(cell)}</td>" for cell in row) + "</tr>"
    yield "</table><h2>Claims</h2>"
    for claim in claims(results):
        yield f"<h3>{told(claim.claim)}: {claim.verdict}</h3><p>{told(claim.text)}</p>"
    yield "<h2>Tables built</h2><ul>"
    for r in results.rendered:
        for note in r.notes:
            yield f"<li>{told(r.pair.material)}: {told(note)}</li>"
    yield "</ul>"
