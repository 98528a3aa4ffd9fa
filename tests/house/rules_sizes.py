"""Rules of size: files in a folder, lines in a file, lines and branches in a function.

sizes.toml has limits and exceptions.
"""
# SPDX-License-Identifier: Apache-2.0
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

from house_sources import CODE_SUFFIXES, files, without_comments_and_literals

TABLE = Path(__file__).resolve().parent / "sizes.toml"
BRANCH = re.compile(r"\b(?:if|for|while|case|catch)\b|&&|\|\||\?")
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.MULTILINE)
ATTRIBUTE = re.compile(r"\[\[[^\[\]]*(?:\[[^\]]*\][^\[\]]*)*\]\]")
CONTROL = {"if", "for", "while", "switch", "catch", "do", "else", "try", "constexpr", "return", "requires"}
NOT_A_FUNCTION = re.compile(r"(?:^|\s)(?:namespace|class|struct|union|enum|concept)\b")
# After the parameters: qualifiers, a trailing return type or constraints may stand before the body.
PARAMETERS_END = re.compile(r"\)\s*(?:(?:const|volatile|noexcept|override|final|mutable|try|&&?)\s*|noexcept\s*\([^{}]*\)\s*|->\s*[^(){};]+(?:\([^(){};]*\))?[^(){};]*"
                            r"|requires\b[^{};]*)*$")
INITIALIZERS = re.compile(r"\)\s*(?:noexcept\s*(?:\([^()]*\))?\s*)?:(?!:)")


@dataclass
class Function:
    """A function's name, its first and last line, from the brace that opens its body, and its cyclomatic complexity."""
    name: str
    first: int
    last: int
    complexity: int

    @property
    def lines(self):
        return self.last - self.first + 1


def functions(text):
    """The functions of a C++ source; lambdas count as part of the function around them.

    The scan follows braces in the text without comments, literals and preprocessor lines: outside of functions, a brace after a
    parameter list opens a body. Complexity is 1 plus the count of if, for, while, case, catch, &&, || and ?. Where #if and #else
    both open a brace the scan loses count and raises ValueError.
    """
    code = DIRECTIVE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), without_comments_and_literals(text))
    code = ATTRIBUTE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), code)
    stack, head = [], 0  # stack: kind of each open brace; head: where the declaration before the next brace begins
    start, name, round_brackets = None, "", 0
    for match in re.finditer(r"[{}();]", code):
        position, character = match.start(), match[0]
        if start is not None:  # within a function: only its end matters
            if character == "{":
                stack.append("inner")
            elif character == "}":
                if stack.pop() == "function":
                    body = code[start:position]
                    yield Function(name, code.count("\n", 0, start) + 1, code.count("\n", 0, position) + 1,
                                   1 + len(BRANCH.findall(body)))
                    start, head = None, position + 1
            continue
        if character in "()":
            round_brackets += 1 if character == "(" else -1
        elif character == ";":
            head = position + 1 if round_brackets <= 0 else head
        elif character == "{":
            if stack and stack[-1] == "value":  # only a lambda can have a body there
                kind = "function" if is_lambda(code[max(head, position - 200):position]) else "value"
            else:
                kind = kind_of_brace(code[head:position], round_brackets)
            stack.append(kind)
            if kind == "function":
                start, name = position, name_of(code[head:position])
            elif kind == "scope":
                head = position + 1
        elif not stack:
            raise ValueError(f"line {code.count(chr(10), 0, position) + 1}: a brace closes nothing")
        elif stack.pop() == "scope":
            head = position + 1
    if stack:
        raise ValueError(f"{len(stack)} braces are not closed")


def kind_of_brace(head, round_brackets):
    """What a brace opens after this declaration: "function", "scope" (namespace, class) or "value" (initializer)."""
    head = head.strip()
    head = re.sub(r"^(?:public|private|protected)\s*:", "", head).strip()
    if round_brackets > 0:
        return "function" if is_lambda(head) else "value"
    initializers = INITIALIZERS.search(head)
    if initializers and head[initializers.end():].strip() and re.search(r"[\w>]$", head):
        return "value"  # of a member, before the body of a constructor
    if NOT_A_FUNCTION.search(head) and not PARAMETERS_END.search(head):
        return "scope"
    if initializers and re.search(r"[)}]$", head):
        return "function"
    if is_lambda(head) or PARAMETERS_END.search(head) and not re.search(r"(?<![=!<>])=\s*[^=]*$", re.sub(r"operator\s*[^\s\w(]+", "", head).split("(")[0]):
        return "function"
    if not head or re.match(r'extern\s*$', head):
        return "scope"
    return "scope" if NOT_A_FUNCTION.search(head) and "(" not in head else "value"


def is_lambda(head):
    return re.search(r"\[[^\[\]]*\]\s*(?:<[^{};]*>\s*)?(?:\((?:[^(){};]|\([^(){};]*\))*\)\s*)?(?:mutable\s*|noexcept\s*|constexpr\s*)*(?:->\s*[^(){};]+)?$", head) is not None \
        and ("=" in head or "(" in head.split("[")[0])


def name_of(head):
    """The name before the parameters; a test of GoogleTest is named Suite.Name."""
    test = re.search(r"\b(?:TYPED_TEST_P|TYPED_TEST|TEST_P|TEST_F|TEST)\s*\(\s*(\w+)\s*,\s*(\w+)\s*\)", head)
    if test:
        return f"{test[1]}.{test[2]}"
    found = re.search(r"((?:[\w~]+\s*(?:<[^<>()]*>)?\s*::\s*)*(?:operator\s*(?:\(\s*\)|\[\s*\]|[^\s\w(]+|\w+)|~?\w+))\s*\(", head)
    return re.sub(r"\s+", "", found[1]) if found else "lambda"


class Sizes:
    """Limits and exceptions; each exception has a reason."""

    def __init__(self, table=None):
        if table is None:
            with open(TABLE, "rb") as file:
                table = tomllib.load(file)
        self.folder_files, self.file_lines = table["folder_files"], table["file_lines"]
        self.function_lines, self.function_complexity = table["function_lines"], table["function_complexity"]
        self.long_files = table.get("long_files", {})
        self.long_functions = table.get("long_functions", {})


def check_sizes(root, layers, sizes=None):
    """No folder of code has more than 60 sources, no source more than 400 lines; tables of data (`*_tables.cpp`) are exempt."""
    sizes = sizes or Sizes()
    counts = {}
    for path, text in files(root, ("cpp", "python", "script"), at_root=False):
        if not path.endswith(CODE_SUFFIXES):
            continue
        folder = path.rsplit("/", 1)[0]
        counts[folder] = counts.get(folder, 0) + 1
        lines = text.count("\n")
        if lines > sizes.file_lines and not path.endswith("_tables.cpp") and path not in sizes.long_files:
            yield f"{path}: {lines} lines; at most {sizes.file_lines}, or a reason in tests/house/sizes.toml"
        if path in sizes.long_files and lines <= sizes.file_lines:
            yield f"{path}: {lines} lines, so tests/house/sizes.toml need not list it any more"
    for folder, count in sorted(counts.items()):
        if count > sizes.folder_files:
            yield f"{folder}: {count} sources; at most {sizes.folder_files} in one folder"


def check_functions(root, layers, sizes=None):
    """No C++ function has more than 120 lines or a cyclomatic complexity above 30 without a reason in sizes.toml."""
    sizes = sizes or Sizes()
    for path, text in files(root, ("cpp",), at_root=False):
        try:
            found = list(functions(text))
        except ValueError as error:
            yield f"{path}: its functions cannot be found: {error}"
            continue
        listed = {key for key in sizes.long_functions if key.startswith(path + ":")}
        for function in found:
            key = f"{path}:{function.name}"
            if function.lines <= sizes.function_lines and function.complexity <= sizes.function_complexity:
                continue
            if key in sizes.long_functions:
                listed.discard(key)
            else:
                yield (f"{path}:{function.first}: {function.name} has {function.lines} lines (at most {sizes.function_lines}) and a "
                       f"complexity of {function.complexity} (at most {sizes.function_complexity})")
        for key in sorted(listed):
            yield f"{key}: within the limits or gone, so tests/house/sizes.toml need not list it any more"
