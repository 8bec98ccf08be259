#!/usr/bin/python3
"""Checks that the documentation agrees with the program.

    tests/check_docs.py                       what needs no program: files, links, style, sources of published figures, no loose ends
    tests/check_docs.py --voile build/voile   also subcommands, options and keys of the case file
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "runs" / "lib")]

from docs_style import check_style, counts  # noqa: E402
from solver import environment  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
# Folders that a documented command creates.
CREATED = ("results", "build", "blade")
# Marks of unfinished work, spelt so that this file passes its own check.
UNFINISHED = ("TO" "DO", "FIX" "ME", "X" * 3)


def pages():
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "runs").rglob("*.md")])


def name_of(path):
    return str(path.relative_to(ROOT))


def fenced_blocks(path):
    """(language, line number, text) of every fenced block."""
    blocks, start, language, lines = [], None, "", []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        fence = re.match(r"^\s*```(\w*)\s*$", line)
        if fence and start is None:
            start, language, lines = number, fence.group(1), []
        elif fence:
            blocks.append((language, start, "\n".join(lines)))
            start = None
        elif start is not None:
            lines.append(line)
    if start is not None:
        blocks.append(("unclosed", start, ""))
    return blocks


# --------------------------------------------------------------------------------------------------- without program

def check_loose_ends():
    pattern = re.compile(rf"\b({'|'.join(UNFINISHED)})\b")
    for path in [*pages(), *(p for d in ("include", "src", "tests", "runs", "meshes") for p in (ROOT / d).rglob("*"))]:
        if not path.is_file() or "__pycache__" in path.parts or path.suffix in (".png", ".h5"):
            continue
        for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
            if pattern.search(line):
                yield f"{name_of(path)}:{number}: loose end: {line.strip()}"


def check_versions():
    """One version everywhere."""
    version = re.search(r"project\(Voile VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
    for name, pattern in (("pyproject.toml", r'^version = "(.*)"$'), ("CITATION.cff", "^version: (.*)$"), ("CHANGELOG.md", r"^## \[(\d.*)\]")):
        found = re.search(pattern, (ROOT / name).read_text(), re.M)[1]
        if found != version:
            yield f"{name}: version {found}; CMakeLists.txt has {version}"


def check_sources():
    for path in sorted((ROOT / "runs" / "reference").glob("*.csv")):
        if not path.read_text().startswith("# Source: "):
            yield f"{name_of(path)}: the first line does not name the source (# Source: ...)"
    for case in sorted((ROOT / "runs").rglob("case.toml")):
        if not any((folder / "README.md").is_file() for folder in (case.parent, case.parent.parent)):
            yield f"{name_of(case.parent)}: there is no README.md"


def anchors(path):
    """Names of the headings of a page, as links have them."""
    headings = re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```", "", path.read_text(), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", h)).strip().lower().replace(" ", "-") for h in headings}


def check_links():
    for path in pages():
        text = path.read_text()
        for target in [*re.findall(r"\]\(([^)\s]+)[^)]*\)", text), *re.findall(r'<img src="([^"]+)"', text)]:
            file, _, anchor = target.partition("#")
            where = path.parent / file if file else path
            if re.match(r"[a-z]+:", target):
                continue
            if not where.exists():
                yield f"{name_of(path)}: broken link to {target}"
            elif anchor and where.suffix == ".md" and anchor not in anchors(where):
                yield f"{name_of(path)}: {file or 'this page'} has no heading #{anchor}"


def check_cited():
    """Pages that code, tests, studies and meshes name are there."""
    for folder in ("include", "src", "tests", "runs", "python", "meshes"):
        for path in sorted(p for p in (ROOT / folder).rglob("*") if p.is_file() and "__pycache__" not in p.parts and p.suffix not in (".png", ".h5")):
            for target in set(re.findall(r"\b((?:docs|runs/convergence|runs/element_study)/[\w/.-]+\.md)\b", path.read_text(errors="replace"))):
                if not (ROOT / target).exists() and "MEMBRANE" not in target:
                    yield f"{name_of(path)}: there is no {target}"


def check_reached():
    """Every page of docs is linked from another one."""
    linked = {(p.parent / t.partition("#")[0]).resolve() for p in pages() for t in re.findall(r"\]\(([^)\s]+)[^)]*\)", p.read_text())}
    yield from (f"{name_of(p)}: no page links to it" for p in (ROOT / "docs").rglob("*.md") if p.resolve() not in linked)


def check_names():
    """What pages call by its name in the code (`room::Class::method`, `src/room/file`) is there."""
    sources = [p for d in ("include", "src") for p in (ROOT / d).rglob("*") if p.suffix in (".hpp", ".cpp")]
    words = set(re.findall(r"\w+", "\n".join(p.read_text() for p in sources)))
    rooms = {p.name for p in (ROOT / "src").iterdir()}
    files = {str(p.relative_to(ROOT / "src").with_suffix("")) for p in sources if (ROOT / "src") in p.parents}
    for path in pages():
        text = path.read_text()
        for room, rest in re.findall(rf"`({'|'.join(rooms)})((?:::\w+)+)", text):
            for gone in [n for n in rest.split("::")[1:] if n not in words]:
                yield f"{name_of(path)}: {room}{rest}: there is no {gone} in the code"
        for file in re.findall(rf"`(?:src/|voile/)?((?:{'|'.join(rooms)})/\w+)(?:\.[ch]pp)?`", text):
            if file not in files and not (ROOT / "tests" / "unit" / file).exists() and not any(f.startswith(file) for f in files):
                yield f"{name_of(path)}: there is no {file} in the code"


def check_fences():
    for path in pages():
        for language, line, _ in fenced_blocks(path):
            if language == "unclosed":
                yield f"{name_of(path)}:{line}: fenced block is not closed"


def commands_of(text):
    """Command lines of a block: continuation lines joined, prompts and comments removed."""
    for line in text.replace("\\\n", " ").splitlines():
        line = re.sub(r"\s#.*$", "", line.strip().removeprefix("$ "))
        if line and not line.startswith("#"):
            yield line


def is_placeholder(word):
    return word.isupper() or "CASE" in word or "MESH" in word or "DIR" in word or "<" in word


def check_commands(subcommands, options):
    """`subcommands` and `options` are None without the program."""
    for path in pages():
        for language, line, text in fenced_blocks(path):
            if language in ("toml", "csv", "cpp", "text"):
                continue
            for command in commands_of(text):
                for problem in command_problems(shlex.split(command), subcommands, options):
                    yield f"{name_of(path)}:{line}: {command}\n    {problem}"


def command_problems(words, subcommands, options):
    if words[0].startswith(("./runs/", "runs/", "./tests/", "tests/")) and not (ROOT / words[0]).is_file():
        yield f"there is no {words[0]}"
    if words[0] == "mpirun":
        at = next((i for i, w in enumerate(words) if Path(w).name == "voile"), None)
        if at is None:
            return
        words = words[at:]
    if Path(words[0]).name != "voile":
        return
    arguments = words[1:]
    positional = [w for i, w in enumerate(arguments) if not w.startswith("-") and not (i and arguments[i - 1].startswith("-"))]
    for word in arguments:
        if word.startswith("--") and options is not None and word.split("=")[0] not in options:
            yield f"the program has no option {word}"
    if not positional:
        return
    if subcommands is not None and positional[0] not in subcommands:
        yield f"the program has no command '{positional[0]}'"
    for file in positional[1:]:
        if "/" not in file:
            continue  # of the reader's folder
        if not is_placeholder(file) and file.split("/")[0] not in CREATED and not (ROOT / file).exists():
            yield f"there is no file {file}"


# ----------------------------------------------------------------------------------------------------- with program

def output_of(voile, *arguments):
    done = subprocess.run([str(voile), *arguments], env=environment(), text=True, capture_output=True)
    if done.returncode != 0:
        raise SystemExit(f"{voile} {' '.join(arguments)} ended with code {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def check_reference(reference):
    path = ROOT / "docs" / "reference" / "case.md"
    if not path.is_file():
        yield f"{name_of(path)} does not exist; create it with: voile reference > docs/reference/case.md"
    elif path.read_text() != reference:
        yield f"{name_of(path)} differs from the program; renew it with: voile reference > docs/reference/case.md"


def reference_keys(reference):
    """Section -> its keys, from the tables of the reference page. The section "" holds the keys outside all sections."""
    keys, section = {"": set()}, ""
    for line in reference.splitlines():
        heading = re.match(r"^#+\s+`?\[+(\w+)\]+`?", line)
        row = re.match(r"^\|\s*`(\w+)`", line)
        if heading:
            section = heading.group(1)
            keys.setdefault(section, set())
        elif row:
            keys[section].add(row.group(1))
    return keys


def check_toml_blocks(keys):
    for path in pages():
        for language, line, text in fenced_blocks(path):
            if language != "toml":
                continue
            where = f"{name_of(path)}:{line}"
            try:
                block = tomllib.loads(text)
            except tomllib.TOMLDecodeError as error:
                yield f"{where}: {error}"
                continue
            yield from (f"{where}: {problem}" for problem in unknown_keys(block, keys))


def unknown_keys(block, keys):
    for name, value in block.items():
        tables = value if isinstance(value, list) else [value]
        if not isinstance(tables[0] if tables else None, dict):
            if name not in keys[""]:
                yield f"unknown key '{name}'"
        elif name not in keys:
            yield f"unknown section '{name}'"
        else:
            yield from (problem for table in tables for problem in unknown_in_section(name, table, keys))


def unknown_in_section(name, table, keys):
    """Keys of a section that it does not have; stages have sections of their own, and what holds in them names them."""
    staged = name in ("support", "load", "mass", "spring", "obstacle", "contact_rule", "initial_velocity")
    for key, value in table.items():
        if name == "stage" and isinstance(value, dict) and key in keys:
            yield from unknown_in_section(key, value, keys)
        elif key not in keys[name] and not (staged and key == "stages"):
            yield f"unknown key '{name}.{key}'"


def check_man_and_completion(subcommands, options):
    man = (ROOT / "docs" / "man" / "voile.1").read_text().replace("\\-", "-")
    completion = (ROOT / "docs" / "completion" / "voile.bash").read_text()
    for word in sorted(subcommands | options):
        for name, text in (("docs/man/voile.1", man), ("docs/completion/voile.bash", completion)):
            if word != "--help" and not re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", text):
                yield f"{name} does not know {word}"


def check_cases(voile):
    # Fabrics are TOML as well, but no cases. Some scenes of contact need meshes that a script makes, garments a body.
    subprocess.run([ROOT / "runs" / "contact" / "scenes", "--make"], check=True, stdout=subprocess.DEVNULL)
    for maker in (ROOT / "runs" / "garments").glob("*/body"):
        subprocess.run([maker, maker.with_suffix(".obj")], check=True, stdout=subprocess.DEVNULL)
    # The template of a garment gets its body from `voile init`, which a regression test runs.
    cases = sorted(p for p in (ROOT / "runs").rglob("*.toml") if p.parent.name != "fabrics" and p.parent != ROOT / "runs" / "templates" / "garment")

    def check(case):
        return subprocess.run([str(voile), "check", str(case)], env=environment(), text=True, capture_output=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for case, done in zip(cases, pool.map(check, cases)):
            if done.returncode != 0:
                yield f"{name_of(case)}: voile check: {(done.stdout + done.stderr).strip()}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--voile", type=Path, help="the program to compare with")
    voile = parser.parse_args().voile
    problems = [*check_loose_ends(), *check_versions(), *check_sources(), *check_links(), *check_cited(), *check_reached(), *check_names(), *check_fences(),
                *check_style()]
    subcommands = options = None
    if voile:
        voile = voile.resolve()
        help_text = output_of(voile, "--help")
        subcommands = set(re.findall(r"^  ([\w-]+)  ", help_text.partition("Subcommands:")[2], re.M))
        options = set(re.findall(r"--[\w-]+", help_text + "".join(output_of(voile, s, "--help") for s in sorted(subcommands))))
        reference = output_of(voile, "reference")
        keys = reference_keys(reference)
        if not subcommands or not keys.get("mesh"):
            raise SystemExit("tests/check_docs.py does not understand `voile --help` or `voile reference` any more")
        problems += [*check_reference(reference), *check_toml_blocks(keys), *check_cases(voile),
                     *check_man_and_completion(subcommands, options)]
    problems += check_commands(subcommands, options)
    print("\n".join(problems) if problems else f"{len(pages())} pages agree with {'the program' if voile else 'the files'}")
    print(counts())
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
