"""Rule of order: no expression draws two random numbers whose order the compiler chooses.

The arguments of a call and the operands of most operators are evaluated in an order that compilers
choose, so that V3f(random(), random(), random()) differs between g++ and clang++; V3f{random(),
random(), random()} does not, because the elements of a list in braces are evaluated in turn.
"""
# SPDX-License-Identifier: Apache-2.0
import re

from house_sources import files, line_of, without_comments_and_literals

GENERATOR = r"(?:rng|random|generator|draws|numbers)"
INNER = r"\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)"  # brackets that hold brackets twice at most
# random(), uniform(random, 0, 1), random.next_1d(), any.next_2d(), and the names of lambdas that
# draw.
DRAW = re.compile(
    rf"\b{GENERATOR}\s*\(\s*\)|\b[a-z]\w*\s*\(\s*{GENERATOR}\s*(?:,(?:[^()]|{INNER})*)?\)"
    rf"|\b{GENERATOR}\s*\.\s*(?!size\b|empty\b|front\b|back\b|begin\b|end\b|data\b|find\b|push_back\b|value\b|state\b|random\b)\w+\s*{INNER}"
    r"|\b\w+\s*\.\s*next_\w+\s*\(\s*\)|\b(?:uniform|pick|draw|anywhere)\s*\(\s*\)")
MARK = "\x02"
BEFORE_CALL = re.compile(r"[\w>\])]\s*$")
BEFORE_CONDITION = re.compile(r"\b(?:if|for|while|switch)\s*(?:constexpr\s*)?$")
# Between these one side is evaluated before the other (C++17).
SEQUENCED = re.compile(r"&&|\|\||<<|>>|[?;,{}]|(?<!:):(?!:)|(?<![=!<>])=(?!=)")


def marked(code):
    """The code with MARK and spaces in place of each draw, line by line and column by column."""
    return DRAW.sub(lambda match: MARK + re.sub(r"[^\n]", " ", match[0][1:]), code)


class Bracket:
    """An open bracket: whether it holds the arguments of a call, and how many of them draw."""

    def __init__(self, position, kind):
        self.position, self.kind, self.draws, self.drawing_arguments = position, kind, False, 0

    def end_argument(self):
        self.drawing_arguments += self.draws
        self.draws = False


def disordered(text):
    """The lines of a C++ source that draw twice in an order that the compiler chooses."""
    code = marked(without_comments_and_literals(text))
    if MARK not in code:
        return []
    lines, pieces, open_brackets = set(), list(code), []
    for match in re.finditer(rf"[(){{}}\[\],]|{MARK}", code):
        position, character = match.start(), match[0]
        if character in "([{":
            before = code[max(position - 40, 0):position]
            kind = "" if character != "(" else "condition" if BEFORE_CONDITION.search(before) else "call" if BEFORE_CALL.search(before) else ""
            open_brackets.append(Bracket(position, kind))
        elif not open_brackets:
            continue
        elif character == MARK:
            for bracket in open_brackets:
                bracket.draws = True
        elif character == ",":
            open_brackets[-1].end_argument()
        else:
            bracket = open_brackets.pop()
            bracket.end_argument()
            if bracket.kind == "condition":
                pieces[position] = ";" # what follows is a statement
            if bracket.kind == "call" and bracket.drawing_arguments > 1:
                lines.add(line_of(code, bracket.position))
    begin, code = 0, "".join(pieces)
    for match in [*SEQUENCED.finditer(code), None]:
        piece = code[begin:match.start() if match else len(code)]
        if piece.count(MARK) > 1:
            lines.add(line_of(code, begin + piece.index(MARK)))
        begin = match.end() if match else len(code)
    return sorted(lines)


def check_order(root, layers):
    """No expression draws two random numbers as arguments of one call or as operands of one operator."""
    for path, text in files(root, ("cpp",), at_root=False):
        for line in disordered(text):
            yield f"{path}:{line}: two random draws in an order that the compiler chooses; use braces or separate statements"
