"""The statements of a PTX function as statements of C++."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re

from ptx_text import PtxError, memory_of

SPECIAL = {"%lanemask_lt": "t.lanemask_lt", "%tid.x": "t.tid_x", "%ntid.x": "t.ntid_x", "%ctaid.x": "t.ctaid_x", "%nctaid.x": "t.nctaid_x"}
REGISTERS = {"pred": "bool", "b16": "u16", "b32": "u32", "b64": "u64", "f32": "f32", "f64": "f64"}
FLOATS = {"u32": "f32", "u64": "f64"}
# What memory has of a type: its type in C++.
IN_MEMORY = {kind + bits: cpp + bits for kind, cpp in (("b", "u"), ("u", "u"), ("s", "i"), ("f", "f")) for bits in ("8", "16", "32", "64")}
DIRECTIVES = (".reg", ".local", ".param", ".pragma")
BYTES = {"8": 1, "6": 2, "2": 4, "4": 8}  # by the last digit of a type's bits


def operations():
    """(result, operands) of each instruction that operations.h has; a last operand 'bool&' is the carry."""
    header = (pathlib.Path(__file__).parent / "operations.h").read_text(encoding="utf-8")
    found = {}
    for result, name, operands in re.findall(r"^OP (\w+) (\w+)\(([^)]*)\)", header, re.M):
        found[name] = (result, [operand.split()[0] for operand in operands.split(",") if operand])
    return found


OPERATIONS = operations()


def cpp_name(name):
    return "n" + name.replace("$", "_S_").replace("%", "_")


def bytes_of(kind):
    return BYTES[kind[-1]]


def split_operands(text):
    """Operands at commas that are not in braces."""
    return [part.strip() for part in re.findall(r"(?:\{[^}]*\}|\[[^\]]*\]|[^,])+", text)]


def immediate_postdominators(targets):
    """Of each block of a function, by the blocks that may follow each; the number of blocks stands for its end. Blocks
    without a way to the end get the end (Cooper, Harvey, Kennedy, "A simple, fast dominance algorithm", 2001)."""
    end = len(targets)
    sources = [[] for _ in range(end + 1)]
    for block, following in enumerate(targets):
        for target in following:
            sources[target].append(block)
    order, seen, stack = [], {end}, [(end, iter(sources[end]))]  # backwards, depth first
    while stack:
        block, left = stack[-1]
        source = next((one for one in left if one not in seen), None)
        if source is None:
            order.append(stack.pop()[0])
        else:
            seen.add(source)
            stack.append((source, iter(sources[source])))
    place = {block: number for number, block in enumerate(order)}
    found = {end: end}

    def common(a, b):
        while a != b:
            while place[a] < place[b]:
                a = found[a]
            while place[b] < place[a]:
                b = found[b]
        return a

    changed = True
    while changed:
        changed = False
        for block in reversed(order[:-1]):
            meeting = None
            for target in targets[block]:
                if target in found:
                    meeting = target if meeting is None else common(target, meeting)
            if found.get(block) != meeting:
                found[block] = meeting
                changed = True
    return [found.get(block, end) for block in range(end)]


class FunctionWriter:
    """Writes one function. `names`: those of all functions and variables; `mentioned` are the ones that it refers to."""

    def __init__(self, function, names):
        self.function = function
        self.names = names
        self.mentioned = set()
        self.registers = {}  # types by name
        self.parameters = {one.name: one for one in function.results + function.parameters}
        self.local = None
        self.blocks = []  # instructions in each
        self.targets = []  # of each: labels, None for the block after it; none at all where the function ends
        self.labels = {}  # the number of the block that follows each
        self.needs_block = True
        self.used = set()
        self.at = None

    def error(self, text):
        return PtxError(f"line {self.at.line}: {self.function.name}: {text}: {self.at.text}")

    def place(self):
        """The line within the function, so that the text of one does not depend on others."""
        return self.at.line - self.function.line

    def text(self, signature):
        lines = []
        for statement in self.function.body:
            self.at = statement
            lines.append(self.statement(statement.text))
        counts = ", ".join(str(count) for count in self.blocks)
        meetings = ", ".join(str(block) for block in self.meetings())
        head = [f"{signature} {{", f"static constexpr u32 blocks[] = {{{counts}}};", f"static constexpr u32 meetings[] = {{{meetings}}};"]
        head.append(f'static constexpr Function function{{"{self.function.name}", blocks, meetings}};')
        for register in sorted(self.used):
            head.append(f"{self.registers[register]} {cpp_name(register)};")
        head += ["bool carry;", "const u64 used = t.used();"]
        if self.local:
            head.append(f"const u64 {cpp_name(self.local.name)} = t.enter({self.local.size}, {self.local.align});")
        return "\n".join([*head, *lines, "}", ""])

    def meetings(self):
        """For each block the first one that every way from it comes to: its immediate post-dominator. The number of
        blocks stands for the end of the function."""
        end = len(self.blocks)
        numbers = [[block + 1 if label is None else self.labels[label] for label in labels] or [end] for block, labels in enumerate(self.targets)]
        return immediate_postdominators(numbers)

    def statement(self, text):
        if text in "{}":
            return text
        if text.endswith(":"):
            self.needs_block = True
            self.labels[text[:-1]] = len(self.blocks)
            return f"{cpp_name(text[:-1])}:"
        word = text.split()[0]
        if word.startswith("."):
            return self.directive(word, text)
        block = ""
        if self.needs_block:
            block = f"STEP({len(self.blocks)});\n"
            self.blocks.append(0)
            self.targets.append([None])
            self.needs_block = False
        self.blocks[-1] += 1
        guard = ""
        if match := re.match(r"@(!?)(%\w+)\s+(.*)", text):
            guard = f"if ({match[1]}{self.register(match[2], 'bool')}) "
            text = match[3]
            if not text.startswith("bra"):
                raise self.error("only branches may have a guard")
            self.targets[-1].append(text.split()[-1])
        opcode, _, operands = text.partition(" ")
        return block + guard + self.instruction(opcode, operands)

    def directive(self, word, text):
        if word not in DIRECTIVES:
            raise self.error("this directive is not known")
        if word == ".reg":
            match = re.fullmatch(r"\.reg \.(\w+) ([%\w]+?)(?:<(\d+)>)?", text)
            if not match or match[1] not in REGISTERS:
                raise self.error("these registers are not known")
            if not match[2].startswith("%"):  # of a scope of its own
                self.registers[match[2]] = REGISTERS[match[1]]
                return f"{REGISTERS[match[1]]} {cpp_name(match[2])};"
            numbers = range(int(match[3])) if match[3] else [""]
            self.registers.update({f"{match[2]}{number}": REGISTERS[match[1]] for number in numbers})
            return ""
        if word == ".pragma":
            if text != '.pragma "nounroll"':
                raise self.error("this pragma is not known")
            return ""
        memory = memory_of(text.removeprefix(word))
        if memory is None or (word == ".local" and self.local):
            raise self.error("this memory is not known")
        if word == ".local":
            self.local = memory
            return ""
        self.parameters[memory.name] = memory
        return f"alignas({memory.align}) char {cpp_name(memory.name)}[{memory.size}];"

    # --- Operands ---

    def register(self, name, want=None):
        """A register; `want`: its type, or one of the same bits."""
        if name not in self.registers:
            raise self.error(f"{name} is no register")
        if name.startswith("%"):
            self.used.add(name)
        have = self.registers[name]
        return self.cast(cpp_name(name), have, want or have)

    def cast(self, value, have, want):
        if have == want:
            return value
        if FLOATS.get(have) == want:
            return f"number({value})"
        if FLOATS.get(want) == have:
            return f"bits({value})"
        raise self.error(f"an operand has type {have}, not {want}")

    def value(self, text, want):
        """An operand that is read."""
        if text in SPECIAL:
            return self.cast(SPECIAL[text], "u32", want)
        if text in self.registers:
            return self.register(text, want)
        if re.fullmatch(r"0[fd]([0-9A-Fa-f]{8}|[0-9A-Fa-f]{16})", text):
            have = "f32" if text[1] == "f" else "f64"
            number = f"number(u{have[1:]}(0x{text[2:]}))"
            return self.cast(number, have, want)
        if re.fullmatch(r"-?(\d+|0x[0-9A-Fa-f]+)", text):
            number = int(text, 0)
            if want == "bool":
                return "true" if number else "false"
            if want.startswith("f"):
                raise self.error("a whole number where one of floating point is due")
            return f"{want}(0x{number % 2 ** int(want[1:]):x})"
        if self.local and text == self.local.name:
            return self.cast(cpp_name(text), "u64", want)
        if match := re.fullmatch(r"([\w$]+)(?:\+(\d+))?", text):
            if match[1] in self.names:
                self.mentioned.add(match[1])
                return self.cast(f"(u64({cpp_name(match[1])}) + {match[2] or 0})", "u64", want)
        raise self.error(f"{text} is not known")

    def address(self, text):
        """(base, offset) of '[base+offset]'."""
        match = re.fullmatch(r"\[([%\w$]+)(?:\+(-?\d+))?\]", text)
        if not match:
            raise self.error("this address is not known")
        return match[1], int(match[2] or 0)

    def pointer(self, space, text, size, access):
        """The host's address of memory that is accessed."""
        base, offset = self.address(text)
        if space == "param":
            memory = self.parameters.get(base)
            if memory is None or offset < 0 or offset + size > memory.size or offset % size or memory.align % size:
                raise self.error("this is no place of a parameter")
            return f"{cpp_name(base)} + {offset}"
        return f"t.{space}({access}, {self.value(base, 'u64')} + {offset % 2 ** 64}ull, {size}, {{&function, {self.place()}}})"

    # --- Instructions ---

    def instruction(self, opcode, operands):
        name, *words = opcode.split(".")
        special = getattr(self, f"write_{name}", None)
        if special:
            return special(words, operands)
        known = OPERATIONS.get(opcode.replace(".", "_"))
        if name == "mov" and "{" in operands:
            return self.write_vector_move(words, split_operands(operands))
        if not known:
            raise self.error("this instruction is not known")
        result, kinds = known
        to, *arguments = split_operands(operands)
        carries = kinds[-1:] == ["bool&"]
        if len(arguments) != len(kinds) - (1 if carries else 0):
            raise self.error("this instruction has other operands")
        if name == "cvt" and kinds[0] == "u16" and self.registers.get(arguments[0]) == "u32":  # PTX ISA 9.4.1
            kinds = ["u32"]
        values = [self.value(text, kind) for text, kind in zip(arguments, kinds)] + (["carry"] if carries else [])
        return self.assign(to, f"{opcode.replace('.', '_')}({', '.join(values)})", result)

    def assign(self, to, value, have):
        register = self.register(to)
        return f"{register} = {self.cast(value, have, self.registers[to])};"

    def memory_words(self, words, operands):
        """(space, volatile, type, registers, address) of a load or store, in either order of operands."""
        words = list(words)
        volatile = "volatile" in words and not words.remove("volatile")
        space = words.pop(0) if words[0] in ("global", "local", "param") else "generic"
        if space == "global" and words[0] == "nc":  # PTX ISA 9.7.9.9: of memory that the kernel does not write
            words.pop(0)
        count = int(words.pop(0)[1:]) if words[0] in ("v2", "v4") else 1
        kind = IN_MEMORY.get(words[0]) if len(words) == 1 else None
        parts = split_operands(operands)
        address = next((part for part in parts if part.startswith("[")), None)
        registers = [part.strip() for part in next((part for part in parts if part != address), "").strip("{}").split(",")]
        if kind is None or len(parts) != 2 or len(registers) != count:
            raise self.error("this access is not known")
        return space, volatile, kind, registers, address

    def write_ld(self, words, operands):
        space, volatile, kind, registers, address = self.memory_words(words, operands)
        size = bytes_of(kind)
        lines = [f"const char* const p = {self.pointer(space, address, size * len(registers), 'kLoad')};"]
        for i, register in enumerate(registers):
            have = self.registers.get(register)
            if have is None or have == "bool" or bytes_of(have) < size or (kind.startswith("f") and have != kind):
                raise self.error("this register does not take the value")
            read = have if have.startswith("f") else kind
            if bytes_of(read) != size:
                raise self.error("this register does not take the value")
            get = "get_volatile" if volatile else "get"
            lines.append(f"{self.register(register)} = {get}<{read}>(p + {i * size});")
        return "{ " + " ".join(lines) + " }"

    def write_st(self, words, operands):
        space, volatile, kind, registers, address = self.memory_words(words, operands)
        size = bytes_of(kind)
        lines = [f"char* const p = {self.pointer(space, address, size * len(registers), 'kStore')};"]
        stored = kind.replace("i", "u")
        for i, register in enumerate(registers):
            have = self.registers.get(register, stored)
            if have == "bool" or bytes_of(have) < size:
                raise self.error("this register does not have the value")
            value = self.value(register, stored if bytes_of(have) == size else have)
            put = "put_volatile" if volatile else "put"
            lines.append(f"{put}(p + {i * size}, {stored}({value}));")
        return "{ " + " ".join(lines) + " }"

    def write_atom(self, words, operands):
        space = words.pop(0) if words[0] in ("global",) else "generic"
        if len(words) != 2 or words[0] not in ("add", "or", "cas") or words[1] not in ("u32", "u64", "b32", "b64", "s32"):
            raise self.error("this instruction is not known")
        kind = IN_MEMORY[words[1]].replace("i", "u")
        to, address, *values = split_operands(operands)
        pointer = self.pointer(space, address, bytes_of(kind), "kAtomic")
        given = ", ".join([pointer, *(self.value(value, kind) for value in values)])
        return self.assign(to, f"atom_{words[0]}<{kind}>({given})", kind)

    def write_cvta(self, words, operands):
        to, value = split_operands(operands)
        if "_".join(words) not in ("local_u64", "to_local_u64", "global_u64", "to_global_u64"):
            raise self.error("this instruction is not known")
        return self.assign(to, f"t.cvta_{'_'.join(words[:-1])}({self.value(value, 'u64')})", "u64")

    def write_vector_move(self, words, operands):
        """mov.b64 {low, high}, whole, or the other way round."""
        to, value = operands
        whole = words[0].replace("b", "u")
        half = {"u64": "u32", "u32": "u16"}.get(whole)
        parts = [part.strip() for part in (to if to.startswith("{") else value).strip("{}").split(",")]
        if half is None or len(parts) != 2:
            raise self.error("this instruction is not known")
        shift = 8 * bytes_of(half)
        if to.startswith("{"):
            source = self.value(value, whole)
            return " ".join(self.assign(part, f"{half}({source} >> {i * shift})", half) for i, part in enumerate(parts))
        low, high = (self.value(part, half) for part in parts)
        return self.assign(to, f"{whole}({whole}({high}) << {shift} | {low})", whole)

    def write_bra(self, words, operands):
        if words not in ([], ["uni"]) or not re.fullmatch(r"[\w$]+", operands):
            raise self.error("this instruction is not known")
        self.needs_block = True
        if operands not in self.targets[-1]:
            self.targets[-1] = [operands]
        return f"goto {cpp_name(operands)};"

    def write_call(self, words, operands):
        parts = re.fullmatch(r"(?:\(([^()]*)\),\s*)?([\w$]+)(?:,\s*\(([^()]*)\))?", operands)
        if words not in ([], ["uni"]) or not parts or parts[2] not in self.names:
            raise self.error("this instruction is not known")
        self.mentioned.add(parts[2])
        given = [name.strip() for part in (parts[1], parts[3]) if part for name in part.split(",")]
        if any(name not in self.parameters for name in given):
            raise self.error("these parameters are not known")
        self.needs_block = True
        return f"CALL({', '.join([cpp_name(parts[2]), 't', *map(cpp_name, given)])});"

    def write_ret(self, words, operands):
        if words or operands:
            raise self.error("this instruction is not known")
        self.needs_block = True
        self.targets[-1] = []
        return "{ t.leave(used); return; }"

    def write_trap(self, words, operands):
        if words or operands:
            raise self.error("this instruction is not known")
        self.needs_block = True
        self.targets[-1] = []
        return f'fault("{self.at.text} in line {self.place()} of {self.function.name}");'

    # A kernel returns; LLVM's back end writes exit where the program cannot come to.
    write_exit = write_trap
