"""docs/python.md: every block runs, one after the other."""

import os
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

ROOT = Path(__file__).parents[3]


def test_every_block_of_the_page_runs(monkeypatch, capsys):
    page = (ROOT / "docs/python.md").read_text()
    folder = ROOT / "target/python-page"
    folder.mkdir(parents=True, exist_ok=True)
    monkeypatch.chdir(folder)
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 12
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
        said = capsys.readouterr().out
        for promised in re.findall(r"print\(.*\)  # (.*)", block):
            assert promised in said
        with capsys.disabled():
            print(said, end="")
    for picture in ("python-spectrum.png", "python-day.png"):
        assert os.path.getsize(picture) > 10_000
    # What the page says of spectrl2.
    for sun, (direct, diffuse) in names["ratios"].items():
        row = re.search(rf"^\| {sun}° \| ([\d.]+) to ([\d.]+) \| ([\d.]+) to ([\d.]+) \|$", page, re.MULTILINE)
        said = [float(value) for value in row.groups()]
        assert [round(float(value), 2) for value in (direct.min(), direct.max(), diffuse.min(), diffuse.max())] == said
