"""Regression tests of the page for browsers: what is in it, and what a browser shows."""

import json
import re
import shutil
import subprocess

import numpy as np
from common import pixels
from harness import OUT, solve, test
from picturing import Y_UP, ball, draw, glb, thrown
from solver import ROOT

NODE = r"""
const fs = require("fs"), text = fs.readFileSync(process.argv[2], "utf8"), begin = text.lastIndexOf("<script>") + 8;
const page = { exports: {} };
new Function("module", text.slice(begin, text.lastIndexOf("</script>")))(page);
const { RUN, decode, corners } = page.exports, run = decode(RUN);
console.log(JSON.stringify(run.frames.map(f => ({ caption: f.caption, x: [...f.x], bodies: f.bodies && [...f.bodies], value: [...f.values[0]],
  corners: [...corners(f.x, run.meshes[f.mesh], f.values[0]).value], triangles: [...run.meshes[f.mesh]] }))));
"""


def stretched():
    """A strip 0.2 x 0.1 m that is stretched along x by 10 %, whose warp runs along y."""
    return {
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.2, "width": 0.1, "nx": 12, "ny": 6}},
        "material": [{"type": "orthotropic", "young_1": 1e6, "young_2": 1e6, "poisson_12": 0.0, "shear_12": 5e5, "thickness": 5e-4, "direction": [0, 1, 0]}],
        "support": [{"group": "clamp", "type": "hinged"},
                    {"group": "tip", "type": "displacement", "components": ["x", "y", "z"], "value": [0.02, 0, 0]}],
    }


def crossings(line):
    """Where brightness along a line crosses its middle, between pixels."""
    middle = 0.5 * (np.percentile(line, 10) + np.percentile(line, 90))
    at = np.flatnonzero((line[:-1] < middle) != (line[1:] < middle))
    return at + (middle - line[at]) / (line[at + 1] - line[at])


@test
def cloth_in_pictures(report):
    """Stripes of 10 mm tell the strain of a strip in the picture; a GLB has the print and the threads, at the right places."""
    done = solve("pictures_cloth", stretched(), 1)
    png, file = OUT / "pictures_cloth.png", OUT / "pictures_cloth.glb"

    def red(*words):
        """Along the middle of the strip, from above."""
        code, said = draw("render", done.folder, "--output", png, "--view", "top", "--size", "640x480", "--no-stamp", "--no-ground", *words)
        report.check(code == 0, f"render {' '.join(words)}" if code == 0 else said)
        return pixels(png)[220:260].mean(axis=0)[:, 0]

    ends = crossings(red())[[0, -1]]
    stripes = crossings(red("--cloth", "twill", "--print", "stripes:10mm"))
    stripes = stripes[(stripes > ends[0] + 5) & (stripes < ends[1] - 5)]
    report.check(len(stripes) == 19, f"{len(stripes)} edges of 20 stripes")
    metre = np.ptp(ends) / np.ptp(done.results[-1].positions[:, 0])  # [pixels]
    stretch = np.polyfit(np.arange(len(stripes)), stripes, 1)[0] / metre / 0.01
    report.below(abs(stretch - 1.1), 0.01, f"a stretch of {stretch:.4f} is read from stripes, which is 1.1")

    code, said = draw("export", done.folder, "--output", file, "--steps", "last", "--cloth", "knit:2mm", "--print", "checks:10mm", "--quiet")
    report.check(code == 0, "GLB" if code == 0 else said)
    text, accessor = glb(file)
    found = {name: accessor(number) for name, number in text["meshes"][0]["primitives"][0]["attributes"].items()}
    x = found["POSITION"] @ Y_UP.T
    flat = np.column_stack([x[:, 0] / 1.1, x[:, 1]])
    for name, repeat in (("TEXCOORD_0", [0.002, 0.0016]), ("TEXCOORD_1", [0.02, 0.02])):
        shift = found[name] * repeat * [1, -1] - flat
        report.below(np.ptp(shift, axis=0).max(), 1e-5, f"GLB: {name} [m]")
    report.below(abs(found["TANGENT"] - [1, 0, 0, 1]).max(), 1e-5, "GLB: tangents run across the warp")
    material = text["materials"][0]
    uses = {name: t["texCoord"] for name, t in (*material.items(), *material["pbrMetallicRoughness"].items()) if name.endswith("Texture")}
    report.check(uses == {"normalTexture": 0, "occlusionTexture": 0, "baseColorTexture": 1} and text["extensionsUsed"] == ["KHR_materials_sheen"], f"GLB: {uses}")


@test
def view_page(report):
    """The page for browsers holds all frames; its own script reads them back (with Node; without it that is skipped)."""
    case = thrown()
    case["title"] = "</script>"
    results = solve("pictures_thrown", case, 2).results
    file = OUT / "pictures_view.html"
    code, said = draw("view", results.file.parent, "--field", "contact_pressure/membrane_force:larger", "--output", file)
    report.check(code == 0, "the page is written" if code == 0 else said)
    text = file.read_text()
    report.check(text.count("</script>") == 2 and not re.search("<(script|link|img|iframe)[^>]* (src|href)|@import", text), "one file that loads no other")
    report.check('"unit":"m"' in text and " ${run.unit}`" in text and '"on_triangles":true' in text and '"on_triangles":false' in text,
                 "places have the unit of the case, and fields their kind")
    report.check(draw("view", results.file.parent, "--field", "contact_presure", "--output", file)[0] == 2, "an unknown field is a mistake")
    if not shutil.which("node"):
        print("  skip what needs Node")
        return
    done = subprocess.run(["node", "-", file], input=NODE, text=True, capture_output=True)
    frames = json.loads(done.stdout)
    size = np.ptp(np.vstack([np.vstack([s.positions, ball(s)]) for s in results]), axis=0)
    report.check(len(frames) == len(results), f"{len(frames)} frames")
    worst = max(np.abs((np.reshape(f["x"], (-1, 3)) - s.positions) / size).max() for f, s in zip(frames, results))
    report.below(worst, 0.6 / 65535, "positions, of the size of the motion")
    worst = max(np.abs((np.reshape(f["bodies"], (-1, 3)) - ball(s)) / size).max() for f, s in zip(frames, results))
    report.below(worst, 0.6 / 65535, "bodies")
    report.check(all(np.array_equal(f["value"], s["contact_pressure"].astype(np.float32).ravel()) for f, s in zip(frames, results)), "a field, in single precision")
    report.check(all(np.array_equal(f["corners"], np.array(f["value"])[f["triangles"]]) for f in frames), "at the corners of the triangles")


class Browser:
    """Chromium without a display and without a network."""

    def __init__(self, page):
        self.page = page

    def run(self, words, *options):
        return subprocess.run(["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--window-size=640,480",
                               "--virtual-time-budget=4000", "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={OUT / 'chromium'}", *options,
                               f"file://{self.page}#{words}"], capture_output=True, text=True, timeout=120).stdout

    def shot(self, words):
        png = OUT / "pictures_browser.png"
        png.unlink(missing_ok=True)
        self.run(words, f"--screenshot={png}")
        return pixels(png) if png.is_file() else np.zeros((1, 1, 3))

    def after(self, script):
        """The same page with a script after its own."""
        page = self.page.with_name(f"after_{self.page.name}")
        page.write_text(self.page.read_text().replace("</body>", f"<script>{script}</script></body>"))
        return Browser(page)


def seen_at(point, results, azimuth, elevation):
    """Where the page shows a point at first: across and upwards in half heights of the picture."""
    points = np.vstack([np.vstack([s.positions, ball(s)]) for s in results])
    low, high = points.min(axis=0), points.max(axis=0)
    a, e = np.radians([azimuth, elevation])
    back, right = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]), np.array([-np.sin(a), np.cos(a), 0])
    seen = point - (low + high) / 2 - 1.7 * np.linalg.norm(high - low) * back
    return 3.5 * np.array([seen @ right, seen @ np.cross(back, right)]) / -(seen @ back)


@test
def view_in_browser(report):
    """Chromium shows the page: another frame is another picture, the field in its colours; dragging turns, a click tells values (skipped without Chromium)."""
    if not shutil.which("chromium"):
        print("  skip: there is no chromium")
        return
    results = solve("pictures_thrown", thrown(), 2).results
    file = OUT / "pictures_browser.html"
    report.check(draw("view", results.file.parent, "--field", "contact_pressure/displacement:z", "--output", file)[0] == 0, "the page is written")
    browser = Browser(file)

    def coloured(picture):
        """Share that is neither grey nor background."""
        return np.mean(np.ptp(picture, axis=2) > 0.1)

    def shot(words, page=browser):
        """The middle, where neither the colour bar nor the buttons are."""
        return page.shot(words)[40:-60, :-180]

    first, later, meshed = shot("frame=0"), shot("frame=5"), shot("frame=5&mesh")
    report.check(0.01 < coloured(first) < 0.5 and 0.01 < coloured(later) < 0.5, f"the sheet covers {coloured(first):.3f} and {coloured(later):.3f}")
    same = first.shape == later.shape == meshed.shape
    report.check(same and np.mean(abs(first - later).max(axis=2) > 0.1) > 0.01, "a later frame is another picture")
    report.check(same and 0 < np.mean(abs(meshed - later).max(axis=2) > 0.05) < 0.2, "mesh lines are drawn on request")
    turned = shot("frame=5", browser.after("""const event = (name, x) => new MouseEvent(name, { clientX: x, clientY: 200, button: 0, bubbles: true }), canvas = document.getElementById("view");
        canvas.dispatchEvent(event("mousedown", 200)); document.dispatchEvent(event("mousemove", 320)); document.dispatchEvent(event("mouseup", 320));"""))
    report.check(turned.shape == later.shape and np.mean(abs(turned - later).max(axis=2) > 0.1) > 0.01 and 0.01 < coloured(turned) < 0.5, "dragging turns")

    step, vertex = results[5], len(results[5].positions) - 1
    triangle = step.mesh.triangles[(step.mesh.triangles == vertex).any(axis=1)][0]
    x, y = seen_at(0.8 * step.positions[vertex] + 0.2 * step.positions[triangle].mean(axis=0), results, -70, 50)
    clicked = browser.after(f"""const canvas = document.getElementById("view"), half = canvas.clientHeight / 2, place = {{
        clientX: canvas.clientWidth / 2 + half * {x}, clientY: half - half * {y}, bubbles: true }};
        for (const name of ["pointerdown", "pointerup"]) canvas.dispatchEvent(new PointerEvent(name, place));""").run("frame=5&azimuth=-70&elevation=50", "--dump-dom")
    said = re.search(r'id="picked">([^<]*)', clicked)
    said = said[1] if said else "nothing"
    report.check(said.startswith(f"vertex {vertex}: ") and f"{step['displacement'][vertex][2]:.5g}"[:6] in said, f"a click on vertex {vertex} tells: {' / '.join(said.splitlines())}")
