"""Rules of layers and files: includes, links, printing, license lines, READMEs and flags.

layers.toml has the table of layers.
"""
# SPDX-License-Identifier: Apache-2.0
import re
import subprocess
import tomllib
from pathlib import Path

from house_sources import files, without_comments_and_literals

LAYERS = Path(__file__).resolve().parent / "layers.toml"
SOURCE_SUFFIXES = (".h", ".cpp")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
PRINTING = re.compile(
    r"\bstd::(?:cout|cerr|clog|wcout|wcerr|print|println|exit|quick_exit|_Exit|abort|terminate)\b"
    r"|\bfmt::print\b"
    r"|(?<![\w:.>])(?:std)?(?:::)?(?:f?printf|vf?printf|f?puts|f?putc|putchar|perror|exit|_exit|quick_exit|abort)\s*\(")


class Layers:
    def __init__(self, path=LAYERS):
        with open(path, "rb") as file:
            table = tomllib.load(file)
        self.levels = table["levels"]
        self.neighbors = table["neighbors"]
        self.adapters = table["adapters"]
        self.printing = table["printing"]["folders"]

    def may_use(self, folder, other):
        """Whether code of one folder may include headers of, or link, another."""
        return other == folder or self.levels[other] < self.levels[folder] or other in self.neighbors.get(folder, ())

    def folder_of(self, path):
        """The folder of the table that a path from the root lies in, or None."""
        parts = Path(path).parts
        for length in (3, 2, 1):
            folder = "/".join(parts[:length])
            if len(parts) > length and folder in self.levels:
                return folder
        return None


def is_below(path, folder):
    return path == folder or path.startswith(folder + "/")


def sources(root, layers):
    """(path from the root, text) of all sources in the folders of the table, and of strays beside them."""
    for top in ("renderer", "accel"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in SOURCE_SUFFIXES and path.is_file():
                yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8", errors="replace")


def check_includes(root, layers):
    """An include points at its own folder or a lower level; third-party libraries stay in their adapter."""
    for path, text in sources(root, layers):
        folder = layers.folder_of(path)
        if folder is None:
            yield f"{path}: its folder is not in tests/house/layers.toml"
            continue
        for number, line in enumerate(text.splitlines(), 1):
            include = INCLUDE.match(line)
            if not include:
                continue
            name, place = include[2], f"{path}:{number}"
            for prefix, folders in layers.adapters.items():
                if name.startswith(prefix) and not any(is_below(path, allowed) for allowed in folders):
                    yield f"{place}: includes {name}; only {', '.join(folders)} may"
            target = layers.folder_of(name)
            if target is not None:
                if not layers.may_use(folder, target):
                    yield (f"{place}: {folder} (level {layers.levels[folder]}) includes {name} "
                           f"(level {layers.levels[target]}); only lower levels may be included")
                if not (root / name).is_file():
                    yield f"{place}: includes {name}, which does not exist"
            elif include[1] == '"':
                yield f'{place}: includes "{name}"; project headers are spelled from the root, others in <>'


def check_printing(root, layers):
    """Libraries neither print nor end the process."""
    for path, text in sources(root, layers):
        if any(is_below(path, folder) for folder in layers.printing):
            continue
        for number, line in enumerate(without_comments_and_literals(text).splitlines(), 1):
            call = PRINTING.search(line)
            if call:
                yield f"{path}:{number}: {call[0].strip('( ')}: only {', '.join(layers.printing)} may print or end the process"


def check_files(root, layers):
    """Each source opens with a comment and carries the license line; a header has #pragma once; scripts are executable if they begin with #!, no others."""
    for path, text in sources(root, layers):
        if not text.startswith("//"):
            yield f"{path}: the first line is no comment; open with a sentence about the file"
        if "// SPDX-License-Identifier: Apache-2.0" not in text[:2000].splitlines():
            yield f"{path}: no line '// SPDX-License-Identifier: Apache-2.0'"
        if path.endswith(".h") and "#pragma once" not in text:
            yield f"{path}: no #pragma once"
    for path, text in files(root, ("python", "script")):
        executable = (root / path).stat().st_mode & 0o100 != 0
        if text.startswith("#!") and not executable:
            yield f"{path}: begins with #! but may not be executed; chmod +x, or delete the line"
        elif executable and not text.startswith("#!"):
            yield f"{path}: may be executed but does not begin with #!; chmod -x, or name its interpreter"


def anchors(text):
    """The anchors of a Markdown file's headings, as GitHub names them: lower case, words joined by '-', other signs left out; a number for repeated ones."""
    found = []
    for heading in re.findall(r"^#+ +(.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        found.append(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return {name if name not in found[:i] else f"{name}-{found[:i].count(name)}" for i, name in enumerate(found)}


def check_readmes(root, layers):
    """Every folder of the table that exists has a README that names its headers, and what Markdown files link to exists, headings too."""
    for folder in list(layers.levels) + ["scenes", "tests", "bench"]:
        if (root / folder).is_dir() and not (root / folder / "README.md").is_file():
            yield f"{folder}: has no README.md"
    for folder in layers.levels:
        readme = root / folder / "README.md"
        text = readme.read_text(encoding="utf-8") if readme.is_file() else None
        for header in sorted((root / folder).glob("*.h")) if text is not None else []:
            if not re.search(rf"(?<!\w){re.escape(header.stem)}(?!\w)", text):
                yield f"{folder}/README.md: does not name {header.name}"
    if not (root / "README.md").is_file():
        yield "README.md: missing"
    ours = [root / "README.md"] + [path for top in ("renderer", "accel", "scenes", "tests", "bench", "cmake")
                                   for path in sorted((root / top).rglob("*.md"))]
    for path in ours:
        if not path.is_file():
            continue
        for link in re.findall(r"\]\(([^)\s]+)\)", path.read_text(encoding="utf-8")):
            target, _, anchor = link.partition("#")
            if "://" in target:
                continue
            linked = path.parent / target if target else path
            if not linked.exists():
                yield f"{path.relative_to(root).as_posix()}: links to {target}, which does not exist"
            elif anchor and linked.suffix == ".md" and anchor not in anchors(linked.read_text(encoding="utf-8")):
                yield f"{path.relative_to(root).as_posix()}: links to {link}, which is no heading there"


def read_targets(path):
    """The file that tests/house/CMakeLists.txt writes: one line 'folder: target; linked; linked' for each library."""
    folders, links = {}, {}
    for line in path.read_text(encoding="utf-8").splitlines():
        folder, rest = line.split(": ", 1)
        target, *linked = [item.strip() for item in rest.split(";")]
        folders[target] = folder
        links[target] = {item.replace("kindling::", "kindling_") for item in linked}
    return folders, links


def reachable(target, links):
    """Everything that a target links, directly or through others."""
    seen, waiting = set(), [target]
    while waiting:
        for linked in links.get(waiting.pop(), ()):
            if linked in links and linked not in seen:
                seen.add(linked)
                waiting.append(linked)
    return seen


def check_links(root, layers, targets):
    """Targets link in the direction of the table, and every folder that is included is linked, if only through another."""
    folders, links = read_targets(targets)
    included = {}
    for path, text in sources(root, layers):
        for line in text.splitlines():
            include = INCLUDE.match(line)
            if include and layers.folder_of(include[2]):
                included.setdefault(layers.folder_of(path), set()).add(layers.folder_of(include[2]))
    linked_folders = {}
    for target, path in folders.items():
        folder = layers.folder_of(path + "/CMakeLists.txt")
        linked_folders.setdefault(folder, set())
        for linked in links[target]:
            if linked not in folders:
                continue
            other = layers.folder_of(folders[linked] + "/CMakeLists.txt")
            if not layers.may_use(folder, other):
                yield f"{path}/CMakeLists.txt: {target} links {linked} of level {layers.levels[other]}; only lower levels may be linked"
        linked_folders[folder] |= {layers.folder_of(folders[linked] + "/CMakeLists.txt") for linked in reachable(target, links)}
    for folder, wanted in sorted(included.items(), key=str):
        for other in sorted(wanted - {folder} - linked_folders.get(folder, set())):
            if folder in linked_folders:
                yield f"{folder}/CMakeLists.txt: includes headers of {other} but does not link it"


def flags_of_commands(program):
    """The flags of each command, as the program's help lists them: {("farm", "submit"): {"--parts", ...}, ...}."""
    flags = {}
    commands = [()]
    for command in commands:
        text = subprocess.run([program, *command, "--help"], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=True).stdout
        flags[command] = set(re.findall(r"^ {0,4}(?:-\w,)?(--[a-z][a-z0-9-]*)", text, re.MULTILINE))
        for usage in re.findall(r"^ +kindling((?: [a-z]+)+) ", text, re.MULTILINE):
            words = tuple(usage.split())
            if words not in commands:
                commands.append(words)
    return flags


def check_flags(root, program):
    """The flags in the tables of app's README are known to some command, and none of `render` is left out."""
    name = "renderer/app/README.md"
    readme = (root / name).read_text(encoding="utf-8")
    rows = "\n".join(line for line in readme.splitlines() if line.startswith("|"))
    documented = set(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", rows))
    try:
        flags = flags_of_commands(program)
    except subprocess.CalledProcessError as error:
        yield f"{' '.join(map(str, error.cmd))}: exit code {error.returncode}"
        return
    for flag in sorted(documented.difference(*flags.values())):
        yield f"{name}: {flag} is in no help of the program"
    for flag in sorted(flags.get(("render",), set()) - documented - {"--help"}):
        yield f"{name}: {flag} of `kindling render --help` is in none of its tables"
