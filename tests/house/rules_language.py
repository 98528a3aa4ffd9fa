"""Rules of language: words, first sentences, the width of comments, names of tests.

language.toml has the words.
"""
# SPDX-License-Identifier: Apache-2.0
import fnmatch
import re
import tomllib
from pathlib import Path

import house_sources
from house_sources import comment_only_lines, files, line_of, split, split_name

TABLE = Path(__file__).resolve().parent / "language.toml"
IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
GOOGLE_TEST = re.compile(r"^\s*(TYPED_TEST_P|TYPED_TEST|TEST_P|TEST_F|TEST)\s*\(\s*(\w+)\s*,\s*(\w+)\s*\)", re.MULTILINE)
PYTHON_TEST = re.compile(r"^\s*def (test_\w+)\(", re.MULTILINE)
CAMEL_CASE = re.compile(r"[A-Z][A-Za-z0-9]*")
SENTENCE_END = re.compile(r"[.](?=\s|$)")


class Language:
    """The table of banned words, and which files may use some of them all the same."""

    def __init__(self, table=None):
        if table is None:
            with open(TABLE, "rb") as file:
                table = tomllib.load(file)
        self.width = table.get("width", 100)
        self.beginnings = [word.lower() for word in table.get("beginnings", [])]
        self.allowed = table.get("allow", [])
        self.phrases, self.single_words, self.names = [], [], []
        for entry in table.get("words", []):
            pattern, where = "|".join(entry["find"]), entry.get("in", ["text", "names"])
            if "text" in where:
                # Letters bound a word, not underscores, so that names in prose are read too.
                kind = self.phrases if " " in pattern else self.single_words
                kind.append((re.compile(rf"(?<![A-Za-z])(?:{pattern})(?![A-Za-z])"), entry["use"]))
            if "names" in where:
                self.names.append((re.compile(rf"(?<![a-z])(?:{pattern})(?![a-z])"), entry["use"]))
        self.known_words, self.known_names = {}, {}
        tests = table.get("test_names", {})
        self.test_words = [word.lower() for word in tests.get("anywhere", [])]
        self.test_beginnings = [word.lower() for word in tests.get("beginnings", [])]

    def use_for_word(self, word):
        """The replacement of a banned word in lower case, or None."""
        if word not in self.known_words:
            self.known_words[word] = next((use for pattern, use in self.single_words if pattern.fullmatch(word)), None)
        return self.known_words[word]

    def use_for_name(self, name):
        """The replacement for a banned word in an identifier, or None."""
        if name not in self.known_names:
            words = split_name(name)
            self.known_names[name] = next((use for pattern, use in self.names if pattern.search(words)), None)
        return self.known_names[name]

    def in_prose(self, prose):
        """(begin, end, use) of each banned word or phrase in prose as house_sources.split() returns it."""
        text, offsets = house_sources.compact(prose)
        for match in re.finditer(r"[A-Za-z]+", text):
            if use := self.use_for_word(match[0]):
                yield offsets[match.start()], offsets[match.end() - 1] + 1, use
        for pattern, use in self.phrases:
            for match in pattern.finditer(text):
                yield offsets[match.start()], offsets[match.end() - 1] + 1, use

    def allowances(self, rule, path):
        """The entries of [[allow]] for one rule and file."""
        return [entry for entry in self.allowed if entry.get("rule", "words") == rule and fnmatch.fnmatch(path, entry["file"])]


def is_allowed(allowances, word, used):
    """True if one of the entries names the word (or all words, by '*'); notes which."""
    for number, entry in enumerate(allowances):
        if any(allowed == "*" or allowed.lower() in re.sub(r"\s+", " ", word.lower()) for allowed in entry["words"]):
            used.add(number)
            return True
    return False


def check_words(root, layers, language=None):
    """Comments, literals, names and prose are free of the banned words of language.toml."""
    language = language or Language()
    for path, text in files(root):
        allowances, used = language.allowances("words", path), set()
        code, prose = split(path, text)
        for names in (GOOGLE_TEST, PYTHON_TEST):  # check_test_names() reads them
            code = names.sub(lambda match: house_sources.blank(match[0]), code)
        found = {}
        for begin, end, use in language.in_prose(prose):
            word = re.sub(r"\W+", " ", prose[begin:end])
            if not is_allowed(allowances, word, used):
                found.setdefault(begin, (word, use))
        seen = set()
        for match in IDENTIFIER.finditer(code):
            use = None if match[0] in seen else language.use_for_name(match[0])
            seen.add(match[0])
            if use and not is_allowed(allowances, match[0], used):
                found.setdefault(match.start(), (match[0], use))
        for start, (word, use) in sorted(found.items()):
            yield f"{path}:{line_of(text, start)}: '{word}'; use: {use}"
        use = language.use_for_name(Path(path).stem)
        if use and not is_allowed(allowances, Path(path).name, used):
            yield f"{path}:1: the file's name; use: {use}"
        for number, entry in enumerate(allowances):
            if number not in used and "*" not in entry["file"]:
                yield f"{path}: language.toml allows {', '.join(entry['words'])} there, which it does not use any more"


def begins_badly(sentence, language):
    """The banned word with which a sentence begins, or None."""
    word = re.match(r"[^A-Za-z]*([A-Za-z]+)(?!\w*\()", sentence)
    return word[1] if word and word[1].lower() in language.beginnings else None


def first_sentence(path, text):
    """(line number, line) of the sentence that opens a file, or None where it is missing."""
    lines = text.splitlines()
    start = 1 if lines[0].startswith("#!") else 0
    if house_sources.language_of(path) == "python":
        start = next((n for n, line in enumerate(lines) if not line.startswith("#")), start)
    mark = {"cpp": "//", "python": '"""'}.get(house_sources.language_of(path), "#")
    return (start + 1, lines[start]) if start < len(lines) and lines[start].startswith(mark) else None


def check_heads(root, layers, language=None):
    """Sources open with one sentence of at most 100 columns; neither it nor a comment of a header begins with a headless clause."""
    language = language or Language()
    for path, text in files(root, ("cpp", "python", "script")):
        if not text.strip():
            continue
        head = first_sentence(path, text)
        if head is None and path.endswith("CMakeLists.txt"):
            continue
        if head is None:
            yield f"{path}:1: no sentence that describes the file"
            continue
        number, line = head
        sentence = line.strip().strip('"').lstrip("/#! ").rstrip()
        if word := begins_badly(sentence, language):
            yield f"{path}:{number}: begins with '{word}'; begin with a noun phrase or a verb"
        if not SENTENCE_END.search(sentence):
            yield f"{path}:{number}: the first sentence does not end with a period in its first line"
        if len(line) > language.width:
            yield f"{path}:{number}: {len(line)} columns; the first sentence has at most {language.width}"
        if path.endswith(".h") and path.startswith(("renderer/", "accel/")):
            yield from check_comments_of_header(path, text, number, language)


def check_comments_of_header(path, text, head, language):
    """Findings for the comment blocks of a header, without its first line, and for trailing comments in sentences of their own."""
    only = comment_only_lines(path, text)
    for number in only:
        if number == head or number - 1 in only and only[number - 1].strip() != "//":
            continue
        if word := begins_badly(only[number].strip().lstrip("/ "), language):
            yield f"{path}:{number}: a comment begins with '{word}'; say what it returns, does or is"
    for match in house_sources.CPP_TOKEN.finditer(text):
        number = line_of(text, match.start())
        if match["comment"] and match[0].startswith("//") and number not in only:
            word = begins_badly(match[0].lstrip("/<! "), language)
            if word and word[0].isupper():  # `float width; // of the sensor` is no sentence
                yield f"{path}:{number}: a comment begins with '{word}'; say what it returns, does or is"


def check_width(root, layers, language=None):
    """Lines that hold nothing but a comment have at most 100 columns, unless an address or a command line makes them longer."""
    language = language or Language()
    for path, text in files(root, ("cpp", "python", "script")):
        for number, line in comment_only_lines(path, text).items():
            if len(line) > language.width and "://" not in line and not line.lstrip().startswith("#!"):
                yield f"{path}:{number}: a comment of {len(line)} columns; at most {language.width} (tests/house/reflow_comments.py wraps it)"


def test_name_fault(words, language):
    """The reason why a test must not have a name of these words (lower case), or None."""
    if words and words[0] in language.test_beginnings:
        return f"begins with '{words[0]}'"
    joined = f" {' '.join(words)} "
    for banned in language.test_words:
        if f" {banned} " in joined:
            return f"says '{banned}'"
    return None


def check_test_names(root, layers, language=None):
    """Names of GoogleTest's tests are CamelCase, and no test's name is in a banned idiom."""
    language = language or Language()
    for path, text in files(root, ("cpp", "python"), tops=("tests",), at_root=False):
        allowances, used = language.allowances("test_names", path), set()
        tests = []
        code = split(path, text)[0]
        if path.endswith(".cpp") or path.endswith(".h"):
            for match in GOOGLE_TEST.finditer(code):
                for name in (match[2], match[3]):
                    if not CAMEL_CASE.fullmatch(name):
                        yield f"{path}:{line_of(code, match.start(3))}: the name {name} is not CamelCase"
                tests.append((match.start(3), f"{match[2]}.{match[3]}", split_name(match[3]).split()))
        else:
            tests = [(match.start(1), match[1], split_name(match[1]).split()[1:]) for match in PYTHON_TEST.finditer(code)]
        for position, name, words in tests:
            fault = test_name_fault(words, language)
            if fault and not is_allowed(allowances, name, used):
                yield f"{path}:{line_of(code, position)}: the test {name} {fault}; say what is verified"
