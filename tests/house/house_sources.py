"""The source tree as check_house.py reads it: files, comments, literals and code."""
# SPDX-License-Identifier: Apache-2.0
import functools
import io
import re
import tokenize
from pathlib import Path

CPP_SUFFIXES = (".h", ".cpp")
CODE_SUFFIXES = (*CPP_SUFFIXES, ".py", ".sh", ".cmake")
TOP_FOLDERS = ("accel", "bench", "cmake", "renderer", "scenes", "tests")
BREAK = "\x01"  # stands in prose where code was: no phrase reaches across it

# Alternatives are tried in this order, so a quote in a comment opens no string and 1'000 no
# character.
CPP_TOKEN = re.compile(
    r'(?P<comment>//(?:\\\n|[^\n])*|/\*.*?\*/)'
    r'|(?P<raw>(?:u8|[uUL])?R"(?P<delimiter>[^()\\\s]{0,16})\((?P<content>.*?)\)(?P=delimiter)")'
    r'|(?P<string>"(?:\\.|[^"\\\n])*")'
    r"|(?P<number>(?<!\w)\.?\d(?:'?[\w.])*)"
    r"|(?P<character>'(?:\\.|[^'\\\n])+')", re.DOTALL)
SCRIPT_TOKEN = re.compile(r'(?P<comment>(?<![^\s;(])\#[^\n]*)|(?P<string>"(?:\\.|[^"\\])*")', re.DOTALL)
ESCAPE = re.compile(r"\\[abfnrtv0]")


def language_of(path):
    """"cpp", "python", "script" (CMake and shell), "markdown", or None for files that the rules do not read."""
    path = Path(path)
    if path.suffix in CPP_SUFFIXES:
        return "cpp"
    if path.suffix == ".py":
        return "python"
    if path.suffix in (".cmake", ".sh") or path.name in ("CMakeLists.txt", "run"):
        return "script"
    return "markdown" if path.suffix == ".md" else None


def files(root, languages=("cpp", "python", "script", "markdown"), tops=TOP_FOLDERS, at_root=True):
    """(path from the root, text) of all files in these languages below the top folders and, unless at_root is false, beside them."""
    found = [path for top in tops for path in (root / top).rglob("*")]
    if at_root:
        found += [*root.glob("*"), root / ".ci" / "run"]
    for path in sorted(found):
        if language_of(path) in languages and path.is_file():
            yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8", errors="replace")


def blank(text, filler=" "):
    """The same number of lines and columns without any content."""
    return re.sub(r"[^\n]", filler, text)


def split_cpp(text, token=CPP_TOKEN):
    """(code, prose), both of the same lines and columns as the text: code without comments and literals, and their words alone."""
    code, prose, end = [], [], 0
    for match in token.finditer(text):
        before, found = text[end:match.start()], match[0]
        end = match.end()
        code.append(before)
        prose.append(re.sub(r"\S", BREAK, before))
        kind = match.lastgroup if match.lastgroup != "delimiter" else "raw"
        groups = match.groupdict()
        if groups.get("comment") is not None:
            code.append(blank(found))
            prose.append(re.sub(r"^\s*(?://[/!]?|/\*+|\*(?!/))|\*/$|^\s*\#+!?", lambda mark: blank(mark[0]), found, flags=re.MULTILINE))
        elif groups.get("string") is not None or groups.get("raw") is not None:
            code.append(blank(found))
            prose.append(ESCAPE.sub("  ", re.sub(r'^(?:u8|[uUL])?R?"|"$', lambda mark: blank(mark[0]), found)))
        elif kind == "character":
            code.append(blank(found))
            prose.append(re.sub(r"\S", BREAK, found))
        else:
            code.append(found)
            prose.append(re.sub(r"\S", BREAK, found))
    code.append(text[end:])
    prose.append(re.sub(r"\S", BREAK, text[end:]))
    return "".join(code), "".join(prose)


def split_python(text):
    """The same for Python, whose docstrings are literals; a file that Python cannot read is all prose."""
    lines = text.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    spans = []
    try:
        open_literals = []  # from Python 3.12 on, an f-string is several tokens, with those of its code between them
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            kind, first = tokenize.tok_name[token.type], token.start
            if kind == "FSTRING_START":
                open_literals.append(first)
            elif kind == "FSTRING_END":
                first = open_literals.pop()
            if kind in ("COMMENT", "STRING", "FSTRING_END") and not open_literals:
                spans.append(tuple(starts[line - 1] + column for line, column in (first, token.end)))
    except (tokenize.TokenError, SyntaxError):
        return blank(text), text
    code, prose, last = [], [], 0
    for begin, end in spans:
        found = text[begin:end]
        code += [text[last:begin], blank(found)]
        words = re.sub(r"^\#+!?|^[a-zA-Z]{0,2}(?:'''|\"\"\"|'|\")|(?:'''|\"\"\"|'|\")$", lambda mark: blank(mark[0]), found)
        prose += [re.sub(r"\S", BREAK, text[last:begin]), ESCAPE.sub("  ", words)]
        last = end
    return "".join([*code, text[last:]]), "".join([*prose, re.sub(r"\S", BREAK, text[last:])])


@functools.lru_cache(maxsize=8)
def split(path, text):
    """(code, prose) of a file by its language; see split_cpp()."""
    language = language_of(path)
    if language == "cpp":
        return split_cpp(text)
    if language == "python":
        return split_python(text)
    if language == "script":
        return split_cpp(text, SCRIPT_TOKEN)
    return blank(text), re.sub(r"\w+://\S+", lambda url: blank(url[0]), text)


def without_comments_and_literals(text):
    """C++ with comments and literals blanked out, line by line and column by column."""
    return split_cpp(text)[0]


def comment_only_lines(path, text):
    """{line number: line} of lines that hold a comment and nothing else; lines within literals are none."""
    mark = "//" if language_of(path) == "cpp" else "#"
    prose, lines = split(path, text)[1].splitlines(), text.splitlines()
    if language_of(path) == "python":
        code = split_python(text)[0].splitlines()
        tokens = set()
        try:
            tokens = {t.start[0] for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type == tokenize.COMMENT}
        except (tokenize.TokenError, SyntaxError):
            pass
        return {n: line for n, line in enumerate(lines, 1) if n in tokens and not code[n - 1].strip() and line.lstrip().startswith(mark)}
    if language_of(path) == "cpp":
        inside = set()  # lines within block comments and raw strings: the marks there are words
        for match in CPP_TOKEN.finditer(text):
            if "\n" in match[0]:
                first = text.count("\n", 0, match.start()) + 1
                inside |= set(range(first + 1, first + match[0].count("\n") + 1))
        return {n: line for n, line in enumerate(lines, 1) if line.lstrip().startswith(mark) and n not in inside}
    return {n: line for n, line in enumerate(lines, 1) if line.lstrip().startswith(mark) and BREAK not in prose[n - 1]}


def compact(prose):
    """(text, offsets): prose in lower case with single spaces and one BREAK for each gap; offsets[i] is where text[i] was."""
    pieces, offsets = [], []
    for match in re.finditer(r"[^\s\x01]+|[\s\x01]+", prose):
        found = match[0]
        if found[0] == BREAK or found[0].isspace():
            pieces.append(BREAK if BREAK in found else " ")
            offsets.append(match.start())
        else:
            pieces.append(found.lower() if found.isascii() else found)
            offsets += range(match.start(), match.end())
    return "".join(pieces), offsets


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def split_name(name):
    """The words of an identifier in lower case: kMaxSize_px, max_size_px and MAX_SIZE_PX are all 'max size px'."""
    name = re.sub(r"^k(?=[A-Z])", "", name)
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    return " ".join(part.lower() for part in parts)
