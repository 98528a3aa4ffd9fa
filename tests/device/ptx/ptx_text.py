"""Takes PTX text apart: variables, functions, and the statements of their bodies."""
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import re

BYTES = {"8": 1, "16": 2, "32": 4, "64": 8}


class PtxError(Exception):
    """What the translator does not know, with its line."""


@dataclasses.dataclass(frozen=True)
class Statement:
    """One of a body: an instruction or a directive without its ';', 'name:', '{' or '}'."""

    line: int
    text: str


@dataclasses.dataclass(frozen=True)
class Memory:
    """A variable, a parameter or an array of local memory. Without values its bytes are 0."""

    name: str
    align: int
    size: int
    values: str = ""


@dataclasses.dataclass
class Function:
    name: str
    line: int
    is_entry: bool
    max_threads: int  # of a block
    results: list
    parameters: list
    body: list


def memory_of(text):
    """A Memory of '.align 4 .b8 name[24]' or '.b32 name', or None."""
    match = re.fullmatch(r"(?:\.align\s+(\d+)\s+)?\.[busf](8|16|32|64)\s+([\w$]+)(?:\[(\d+)\])?", text.strip())
    if not match:
        return None
    element = BYTES[match[2]]
    return Memory(match[3], int(match[1] or element), element * int(match[4] or 1))


def parameters_of(text, line):
    found = []
    for part in text.split(","):
        words = part.strip()
        if not words:
            continue
        memory = memory_of(words.removeprefix(".param"))
        if not words.startswith(".param") or memory is None:
            raise PtxError(f"line {line}: this parameter is not known: {words}")
        found.append(memory)
    return found


def statements_of(text, line):
    """The statements of a body, which begins at a line."""
    found = []
    at = 0
    token = re.compile(r"\s+|[{}]|[\w$]+:|[^;{}\s][^;]*;|;")
    while at < len(text):
        match = token.match(text, at)
        if not match:
            raise PtxError(f"line {line}: this is no statement: {text[at : at + 60].strip()}")
        words = " ".join(match[0].removesuffix(";").split())
        if words:
            found.append(Statement(line, words))
        line += match[0].count("\n")
        at = match.end()
    return found


FUNCTION = re.compile(r"(?:\.(?:visible|weak)\s+)?\.(entry|func)\s*(?:\(([^()]*)\)\s*)?([\w$]+)\s*\(([^()]*)\)\s*(?:\.maxntid\s+(\d+),\s*1,\s*1\s+\.minnctapersm\s+\d+\s*)?")
VARIABLE = re.compile(r"(?:\.(?:visible|weak)\s+)?\.global\s+([^;={]*?)\s*(?:=\s*\{([^}]*)\})?;")
LINE = re.compile(r"\.(?:version|target|address_size)\b[^\n]*\n")


def end_of_body(text, at):
    """The position of the '}' that closes the '{' at `at`."""
    depth = 0
    for brace in re.compile("[{}]").finditer(text, at):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.start()
    raise PtxError("a body does not end")


def parse(ptx):
    """(variables, functions) of PTX text. Raises PtxError where it has anything else."""
    text = re.sub(r"//[^\n]*", "", ptx)
    variables, functions = [], []
    at = 0
    while at < len(text):
        if text[at].isspace():
            at += 1
            continue
        line = text.count("\n", 0, at) + 1
        if match := LINE.match(text, at):
            at = match.end()
        elif match := VARIABLE.match(text, at):
            memory = memory_of(match[1])
            if memory is None:
                raise PtxError(f"line {line}: this variable is not known: {match[1]}")
            variables.append(dataclasses.replace(memory, values=match[2] or ""))
            at = match.end()
        elif match := FUNCTION.match(text, at):
            at = match.end()
            if text[at] == ";":  # a declaration
                at += 1
                continue
            if text[at] != "{":
                raise PtxError(f"line {line}: this function is not known: {text[at : at + 60].strip()}")
            end = end_of_body(text, at)
            body = statements_of(text[at + 1 : end], text.count("\n", 0, at) + 1)
            results, parameters = parameters_of(match[2] or "", line), parameters_of(match[4], line)
            functions.append(Function(match[3], line, match[1] == "entry", int(match[5] or 1024), results, parameters, body))
            at = end + 1
        else:
            raise PtxError(f"line {line}: this is not known: {text[at : at + 60].strip()}")
    return variables, functions
