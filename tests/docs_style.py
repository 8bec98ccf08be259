"""How the documentation is written: budgets of words and lines, words that are not used, and long sentences.

    tests/docs_style.py           counts, and what breaks a rule
    tests/docs_style.py --long    also every sentence of more than 30 words
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GENERATED = ROOT / "docs" / "reference" / "case.md"
WORDS, PAGE_LINES, README_LINES, DECISION_LINES, LONG_SENTENCE = 40_000, 200, 120, 30, 30

# Pattern -> what to write instead. Prose only: code in fences and backticks is not searched.
AVOIDED = {
    r"without a word": "silently",
    r"(is|are|was|were) told|\btold\b": "warns, reports, prints",
    r"\bsays\b": "warns, reports, prints, states",
    r"\bshares?\b": "fraction (of ...)",
    r"\bfeign\w*": "spurious",
    r"\b(goes|go|going|gone) on (from|with)\b": "continues from, restarts",
    r"\blets? go\b": "releases",
    r"\b(gives?|gave|given) way\b|\byields?\b": "passes through, is ignored",
    r"\b(any|this|each|that|worst) moment\b|moment (when|in which)": "frame, instant",
    r"\bin place of\b": "instead of, replaces",
    r"what (is|lies) (beside|between)": "neighbouring, in between",
    r"\bby now\b": "current",
    r"(?<!\*)\bties?\b": "attachment",
    r"\blooks\b|\b(at one|next|another|two) looks?\b": "remeshing check",
    r"\b(makes do|has its turn|goes by|lets out|comes to rest by)\b": "a verb that names what happens",
    r"\b(now|today|nowadays|no longer|any ?more)\b": "present tense without time",
}


def pages():
    """What is measured: the documentation but for the generated reference, and the front pages."""
    return sorted(p for p in [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"] if p != GENERATED)


def prose(text):
    """Paragraphs and list items in one line each, without code, tables, headings and pictures; code in backticks becomes one word."""
    text = re.sub(r"^\s*```.*?^\s*```\s*$", "\n", text, flags=re.M | re.S)
    text = re.sub(r"^\$\$.*?^\$\$\s*$", "\n", text, flags=re.M | re.S)
    text = re.sub(r"``[^`]+``|`[^`]+`", "code", text)
    text = re.sub(r"\$[^$\n]+\$", "formula", text)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    blocks, current = [], []
    for line in [*text.splitlines(), ""]:
        starts = re.match(r"^\s*([*+-]|\d+\.)\s+", line)
        if not line.strip() or starts or re.match(r"^\s*(\||#|:|<)", line):
            if current:
                blocks.append(" ".join(current))
            current = []
        if line.strip() and not re.match(r"^\s*(\||#|:::|<)", line):
            current.append(re.sub(r"^\s*([*+-]|\d+\.)\s+", "", line).strip())
    return blocks


def sentences(text):
    for block in prose(text):
        for sentence in re.split(r"(?<=[.!?])[)\"*]*\s+(?=[A-Z(\"*]|code|formula)", block):
            if words := re.findall(r"[\w'-]*\w", sentence):
                yield len(words), sentence


def messages():
    """(file, text) of the string literals of the sources that are sentences: adjacent ones are one."""
    for path in sorted((ROOT / "src").glob("*/*.?pp")):
        code = re.sub(r"(?m)^\s*//.*$|\s//\s.*$", "", path.read_text())
        for literal in re.finditer(r'"(?:[^"\\\n]|\\.)*"(?:\s*"(?:[^"\\\n]|\\.)*")*', code):
            text = re.sub(r'"\s*"', "", literal[0])
            if text.count(" ") > 2:
                yield path, re.sub(r"`[^`]*`", "code", text)


def name_of(path):
    return str(path.relative_to(ROOT))


def check_style():
    total = 0
    for path in pages():
        text = path.read_text()
        lines = text.count("\n")
        total += len(text.split()) if path.is_relative_to(ROOT / "docs") else 0
        limit = README_LINES if path.name == "README.md" and path.parent == ROOT else PAGE_LINES
        if path.parent.name == "decisions" and path.name != "README.md":
            limit = DECISION_LINES
        if lines > limit:
            yield f"{name_of(path)}: {lines} lines; at most {limit}"
        for block in prose(text):
            for pattern, instead in AVOIDED.items():
                if found := re.search(pattern, block, re.I):
                    yield f"{name_of(path)}: '{found[0]}' in '{block[max(0, found.start() - 30):found.end() + 30]}'; write: {instead}"
    for number, line in enumerate(GENERATED.read_text().splitlines(), 1):
        line = re.sub(r"`[^`]*`", "code", line)
        yield from (f"{name_of(GENERATED)}:{number}: '{found[0]}'; write: {instead}" for pattern, instead in AVOIDED.items()
                    if (found := re.search(pattern, line, re.I)))
    for path, text in messages():
        for pattern, instead in AVOIDED.items():
            if found := re.search(pattern, text, re.I):
                yield f"{name_of(path)}: '{found[0]}' in '{text[max(0, found.start() - 30):found.end() + 30]}'; write: {instead}"
    if total > WORDS:
        yield f"docs: {total} words; at most {WORDS}"


def counts():
    """One line: words, pages, longest page, sentences, long ones."""
    texts = {p: p.read_text() for p in pages()}
    lengths = [n for t in texts.values() for n, _ in sentences(t)]
    longest = max(texts, key=lambda p: texts[p].count("\n"))
    words = sum(len(t.split()) for p, t in texts.items() if p.is_relative_to(ROOT / "docs"))
    return (f"{words} words in {len(texts)} pages, longest {name_of(longest)} with {texts[longest].count(chr(10))} lines; {len(lengths)} sentences, "
            f"mean {sum(lengths) / max(1, len(lengths)):.1f} words, {sum(n > LONG_SENTENCE for n in lengths)} over {LONG_SENTENCE}")


def main():
    problems = list(check_style())
    if "--long" in sys.argv:
        for path in pages():
            for n, sentence in sentences(path.read_text()):
                if n > LONG_SENTENCE:
                    print(f"{name_of(path)}: {n} words: {sentence}")
    print("\n".join(problems))
    print(counts())
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
