# The site of this folder: cmake --build build --target docs. Sphinx 5 and MyST 0.18 of Debian 12; no network, MathJax of libjs-mathjax.
import re
import shutil
from pathlib import Path

project = "Voile"
copyright = "the authors of Voile, GPL-3.0-or-later"
extensions = ["myst_parser", "sphinx.ext.mathjax"]
exclude_patterns = ["man", "completion", "Doxyfile"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
html_theme = "alabaster"
html_theme_options = {"description": "Thin shells and fabrics, in parallel", "page_width": "1100px", "sidebar_width": "230px"}
html_sidebars = {"**": ["about.html", "navigation.html", "searchbox.html"]}
html_copy_source = False

MATHJAX = Path("/usr/share/javascript/mathjax")
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_CHTML"
mathjax2_config = {"tex2jax": {"inlineMath": [["\\(", "\\)"]], "displayMath": [["\\[", "\\]"]], "processClass": "math"}}

FOLDERS = ("tutorials", "howto", "reference", "theory", "verification", "developers")


def outside(app, name, source):
    """Links to files of the source folder outside of this one are no pages of the site: their paths are shown."""
    source[0] = re.sub(r"\[([^\]]+)\]\((?:\.\./)+((?:runs|CONTRIBUTING|README|LICENSE)[^)#]*)[^)]*\)", r"\1 (`\2`)", source[0])


def add_contents(app, name, source):
    """The tree of pages: an index lists the pages of its folder, the first one all folders."""
    if name == "index":
        entries = ["gallery", *(f"{folder}/index" for folder in FOLDERS)]
    elif name.endswith("/index"):
        entries = ["*", "decisions/README"] if name == "developers/index" else ["*"]
    elif name.endswith("decisions/README"):
        entries = ["*"]
    else:
        return
    source[0] += "\n\n```{toctree}\n:hidden:\n:glob:\n\n" + "\n".join(entries) + "\n```\n"


def copy_mathjax(app, error):
    target = Path(app.outdir) / "_static" / "mathjax"
    if error or target.is_dir() or not MATHJAX.is_dir():
        return
    for part in ("MathJax.js", "config/TeX-AMS_CHTML.js", "extensions", "jax/element", "jax/input/TeX", "jax/output/CommonHTML",
                 "fonts/HTML-CSS/TeX/woff"):
        (target / part).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (MATHJAX / part).is_dir() else shutil.copy)(MATHJAX / part, target / part)


def setup(app):
    app.connect("source-read", outside)
    app.connect("source-read", add_contents)
    app.connect("build-finished", copy_mathjax)
