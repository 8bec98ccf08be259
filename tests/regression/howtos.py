"""The cases of the how-to pages: each block of keys, laid over a small strip, is accepted by `voile check`."""

import re
import tomllib

from common import strip
from harness import OUT, test
from solver import ROOT, invoke, write_case

PAGES = ROOT / "docs" / "howto"
# Pages whose blocks stand on the strip, and the analysis that they are for.
STRIP = {"choose-contact-numbers": "dynamic", "damp-a-motion": "dynamic", "define-a-laminate": "static", "find-modes": "modal", "find-a-frequency-response": "harmonic",
         "fix-convergence": "static", "follow-a-path": "static", "heat-a-sheet": "static", "hold-rigidly": "static", "inflate-a-membrane": "static", "measure-forces": "static", "move-supports": "dynamic",
         "prestress": "static", "read-results-in-paraview": "static", "remesh": "static", "repeat-a-cell": "static", "restart": "dynamic",
         "start-inside-the-activation-distance": "dynamic", "tune-petsc": "static"}
# Groups of a reader's mesh -> groups of the strip.
GROUPS = {"edge": "tip", "C": "tip", "front/0": "tip", "hem": "tip", "clamp": "clamp", "tip": "tip", "balloon": "plate"}


def blocks_of(page):
    return [tomllib.loads(text) for text in re.findall(r"^```toml\n(.*?)^```$", page.read_text(), re.M | re.S)]


def renamed(value):
    """The groups of the strip instead of those of the page."""
    if isinstance(value, dict):
        return {k: GROUPS.get(v, v) if k in ("group", "first") else renamed(v) for k, v in value.items()}
    return [renamed(v) for v in value] if isinstance(value, list) else value


def laid_over(block, analysis):
    """The strip with the sections of a block; a list of the block replaces or, for supports, follows that of the strip."""
    case = strip(block.get("analysis", analysis))
    if any("history" in load or "leak_area" in load for load in block.get("load", [])) or "time" in block:
        case["analysis"] = "dynamic"
    case["contact"] = {"distance": 1e-3} if "contact_rule" in block else None
    case = {k: v for k, v in case.items() if v is not None}
    for name, section in renamed(block).items():
        case[name] = case[name] + section if name == "support" else case.get(name, {}) | section if isinstance(section, dict) else section
    if "contact_rule" in block:
        case["obstacle"] = [{"name": "floor", "type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]}]
    if "frozen" in case.get("remesh", {}):
        del case["remesh"]["frozen"]
    if "stage" in case:
        case.pop("analysis")
    if case.get("steps", {}).get("control_probe") and "probe" not in block:
        case["steps"].pop("control_probe")
    return case


@test
def howto_cases(report):
    """Blocks of the how-to pages on a strip: no key, value or condition is refused."""
    for name, analysis in STRIP.items():
        blocks = blocks_of(PAGES / f"{name}.md")
        report.check(bool(blocks), f"{name}: {len(blocks)} block(s)")
        for number, block in enumerate(blocks):
            file = OUT / f"howto_{name}_{number}.toml"
            code, text = invoke(["check", write_case(laid_over(block, analysis), file)])
            report.check(code == 0, f"{name}, block {number + 1}: code {code} {text.strip()[-250:] if code else ''}")
