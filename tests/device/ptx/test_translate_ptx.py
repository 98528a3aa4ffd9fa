#!/usr/bin/env python3
"""Tests the translator: small pieces of PTX whose results are known, and those that it must refuse.

usage: test_translate_ptx.py CLANG ROOT
CLANG is clang++-19 with which translated PTX is compiled, ROOT the repository."""
# SPDX-License-Identifier: Apache-2.0
import ctypes
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from instruction_cases import CASES
from translate_function import immediate_postdominators

CLANG, ROOT = "clang++-19", pathlib.Path(__file__).resolve().parents[3]
FLAGS = ["-std=c++20", "-O1", "-w", "-fPIC", "-shared", "-pthread", "-ffp-contract=off", "-ftrivial-auto-var-init=pattern"]
HEAD = ".version 6.0\n.target sm_70\n.address_size 64\n"
PREFIX = {"pred": "%p", "b16": "%rs", "b32": "%r", "b64": "%rd", "f32": "%f", "f64": "%fd"}
REGISTERS = "".join(f".reg .{kind} {prefix}<9>;" for kind, prefix in PREFIX.items())

# Kernels by name. %rd0 is the address of 64 KiB, %r0 the number of the thread.
KERNELS = {
    "carry": "ld.u64 %rd1, [%rd0]; add.cc.s64 %rd2, %rd1, %rd1; addc.cc.s64 %rd3, 5, 0; st.u64 [%rd0], %rd2; st.u64 [%rd0+8], %rd3;",
    "borrow": "ld.u64 %rd1, [%rd0]; sub.cc.s64 %rd2, 3, %rd1; subc.cc.s64 %rd3, 5, 5; subc.cc.s64 %rd4, 9, 0; st.u64 [%rd0], %rd2; st.u64 [%rd0+8], %rd3;"
    "st.u64 [%rd0+16], %rd4;",
    "vectors": "ld.v2.u8 {%rs1, %rs2}, [%rd0+2]; mov.b32 %r1, {%rs2, %rs1}; ld.v4.f32 {%f1, %f2, %f3, %f4}, [%rd0+16];"
    "st.v4.f32 [%rd0+32], {%f4, %f3, %f2, %f1}; st.u32 [%rd0], %r1; mov.b64 {%r2, %r3}, 0x1234567890abcdef; st.v2.u32 [%rd0+8], {%r3, %r2};",
    "sign_of_loads": "ld.s8 %rs1, [%rd0]; ld.s32 %rd1, [%rd0+4]; ld.u8 %rs2, [%rd0]; st.u16 [%rd0+16], %rs1; st.u64 [%rd0+24], %rd1; st.u16 [%rd0+18], %rs2;",
    "numbers": "mul.wide.u32 %rd1, %r0, 4; add.s64 %rd2, %rd0, %rd1; st.u32 [%rd2+4], %r0; atom.add.u32 %r1, [%rd0], 1;",
    "local_memory": "mov.u64 %rd1, depot; cvta.local.u64 %rd2, %rd1; st.u32 [%rd2+4], 7; ld.local.u32 %r1, [%rd1+4]; ld.local.u32 %r2, [%rd1];"
    "cvta.to.local.u64 %rd3, %rd2; sub.s64 %rd3, %rd3, %rd1; st.u32 [%rd0], %r1; st.u32 [%rd0+4], %r2; st.u64 [%rd0+8], %rd3;",
    "call": "{ .param .b32 param0; .param .align 4 .b8 param1[8]; .param .b64 retval0; st.param.b32 [param0+0], 40; st.param.f32 [param1+4], 0f3F800000;"
    "call.uni (retval0), callee, (param0, param1); ld.param.b64 %rd1, [retval0+0]; } st.u64 [%rd0], %rd1;",
    "constants": "mov.u64 %rd1, table; cvta.global.u64 %rd2, %rd1; ld.u16 %rs1, [%rd2+2]; ld.global.nc.u8 %rs2, [%rd1+1]; st.v2.u16 [%rd0], {%rs1, %rs2};",
    "loop": "mov.u32 %r1, 0; mov.u32 %r2, 0; again: add.s32 %r1, %r1, %r2; add.s32 %r2, %r2, 1; setp.lt.u32 %p1, %r2, 10; @%p1 bra again; st.u32 [%rd0], %r1;",
    "exchange": "ld.u64 %rd1, [%rd0]; atom.cas.b64 %rd2, [%rd0], %rd1, 9; atom.cas.b64 %rd3, [%rd0], %rd1, 11; atom.or.b32 %r1, [%rd0], 6; st.u64 [%rd0+8], %rd3;",
}
# Kernels that a GPU ends, with words of the message.
FAULTS = {
    "misaligned": ("ld.u32 %r1, [%rd0+2];", "misaligned address 0x"),
    "misaligned_vector": ("ld.v4.f32 {%f1, %f2, %f3, %f4}, [%rd0+8];", "misaligned address 0x"),
    "misaligned_local": ("mov.u64 %rd1, depot; ld.local.u64 %rd2, [%rd1+4];", "misaligned local address 0x"),
    "outside": ("ld.u32 %r1, [%rd0+65536];", "address outside of all memory 0x"),
    "across_the_end": ("add.s64 %rd1, %rd0, 65532; ld.u32 %r1, [%rd1]; ld.v2.u32 {%r1, %r2}, [%rd1+4];", "address outside of all memory 0x"),
    "local_address_elsewhere": ("mov.u64 %rd1, depot; ld.u32 %r1, [%rd1];", "address outside of all memory 0x"),
    "global_address_as_local": ("ld.local.u32 %r1, [%rd0];", "local address 0x"),
    "local_of_no_function": ("mov.u64 %rd1, depot; ld.local.u32 %r1, [%rd1+16];", "local address 0x10"),
    "division": ("mov.u32 %r1, 0; div.u32 %r2, 1, %r1;", "division by zero"),
    "trap": ("trap;", "trap in line"),
    "deep_stack": ("call.uni deep, ();", "a stack of 16400 bytes"),
}
# What the translator must refuse, with words of the message.
REFUSED = {
    "sin.approx.f32 %f1, %f2;": "this instruction is not known: sin.approx.f32 %f1, %f2",
    "add.f32 %f1, %f2, %f3;": "this instruction is not known: add.f32",
    "add.rn.ftz.f32 %f1, %f2, %f3;": "this instruction is not known",
    "add.rn.f32 %f1, %r2, %f3;": None,  # the bits of a b32 register are a number
    "add.rn.f32 %f1, %rd2, %f3;": "an operand has type u64, not f32",
    "add.rn.f32 %f1, %f2;": "has other operands",
    "add.rn.f32 %f1, %f2, 1;": "a whole number where one of floating point is due",
    "add.s32 %r1, %r2, %r99;": "%r99 is not known",
    "ld.shared.u32 %r1, [%rd1];": "this access is not known",
    "ld.u64 %r1, [%rd1];": "this register does not take the value",
    "ld.f32 %r1, [%rd1];": "this register does not take the value",
    "ld.param.u64 %rd1, [refused_param_1];": "this is no place of a parameter",
    "atom.max.u32 %r1, [%rd1], 2;": "this instruction is not known",
    "call.uni (%r1), nowhere;": "this instruction is not known",
    "@%p1 ret;": "only branches may have a guard",
    "bar.sync 0;": "this instruction is not known",
    ".shared .b32 name;": "this directive is not known",
}
MODULE = """.global .align 2 .b8 table[4] = {1, 2, 3, 4};
.func (.param .b64 func_retval0) callee(.param .b32 callee_param_0, .param .align 4 .b8 callee_param_1[8])
{ .reg .b32 %r<4>; .reg .b64 %rd<2>; ld.param.u32 %r1, [callee_param_0]; ld.param.b32 %r2, [callee_param_1+4]; add.s32 %r3, %r1, %r2;
  mov.b64 %rd1, {%r3, %r1}; st.param.b64 [func_retval0+0], %rd1; ret; }
.func deep() { .local .align 16 .b8 depot[16384]; ret; }
"""


def kernel(name, body):
    return (
        f".visible .entry {name}(.param .u64 {name}_param_0, .param .u32 {name}_param_1)\n{{ .local .align 8 .b8 depot[16]; {REGISTERS}\n"
        f"ld.param.u64 %rd0, [{name}_param_0]; ld.param.u32 %r8, [{name}_param_1]; mov.u32 %r1, %ctaid.x; mov.u32 %r2, %ntid.x; mov.u32 %r3, %tid.x;"
        f"mad.lo.s32 %r0, %r1, %r2, %r3; setp.ge.u32 %p1, %r0, %r8; @%p1 bra $L_end;\n{body}\n$L_end: ret; }}\n"
    )


def case_kernel(number, instruction, kinds):
    """A kernel that takes operands at 8, 16, ... bytes and stores its result at 0."""
    result, *operands = kinds.split()
    names = [f"{PREFIX[kind]}{i + 2}" for i, kind in enumerate(operands)]
    lines = [f"ld.{kind} {name}, [%rd0+{8 * i + 8}];" for i, (kind, name) in enumerate(zip(operands, names))]
    lines.append(f"{instruction} {PREFIX[result]}1, {', '.join(names)};")
    lines.append("selp.u32 %r1, 1, 0, %p1; st.u32 [%rd0], %r1;" if result == "pred" else f"st.{result} [%rd0], {PREFIX[result]}1;")
    return kernel(f"case_{number}", " ".join(lines))


def translate(folder, text):
    """The finished process of the translator."""
    (folder / "test.ptx").write_text(HEAD + MODULE + text, encoding="utf-8")
    script = pathlib.Path(__file__).parent / "translate_ptx.py"
    return subprocess.run([sys.executable, script, folder / "test.ptx", folder, "1"], check=False, capture_output=True, text=True)


class Translated(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.folder.name)
        text = "".join(case_kernel(number, name, kinds) for number, (name, (kinds, _)) in enumerate(CASES.items()))
        text += "".join(kernel(name, body) for name, body in KERNELS.items())
        text += "".join(kernel(name, body) for name, (body, _) in FAULTS.items())
        text += kernel("bounded", "").replace("{", ".maxntid 32, 1, 1\n.minnctapersm 4\n{", 1)
        done = translate(folder, text)
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        sources = [folder / "part_0.cpp", folder / "tables.cpp", ROOT / "tests/device/ptx/run_ptx.cpp", ROOT / "tests/device/ptx/count_steps.cpp", ROOT / "tests/device/fake_cuda.cpp"]
        library = folder / "libtest.so"
        subprocess.run([CLANG, *FLAGS, "-I", ROOT, *sources, "-o", library], check=True)
        cls.driver = ctypes.CDLL(library)
        run = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_uint)
        cls.run_kernel = staticmethod(run.in_dll(cls.driver, "fake_cuda_run"))
        context = ctypes.c_void_p()
        cls.driver.cuDevicePrimaryCtxRetain(ctypes.byref(context), 0)
        cls.driver.cuCtxSetCurrent(context)
        address = ctypes.c_uint64()
        assert cls.driver.cuMemAlloc_v2(ctypes.byref(address), ctypes.c_size_t(65536)) == 0
        cls.memory = (ctypes.c_ubyte * 65536).from_address(address.value)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def launch(self, name, count=1, threads_per_block=32):
        return self.run_kernel(name.encode(), ctypes.addressof(self.memory), count, threads_per_block)

    def write(self, at, value, size=8):
        self.memory[at : at + size] = list(value.to_bytes(size, "little"))

    def read(self, at, size):
        return int.from_bytes(bytes(self.memory[at : at + size]), "little")

    def test_instructions_have_the_results_of_the_specification(self):
        checked = 0
        for number, (name, (kinds, cases)) in enumerate(CASES.items()):
            result = kinds.split()[0]
            size = 4 if result == "pred" else int(result[1:]) // 8
            for *operands, expected in cases:
                self.write(0, 0)
                for i, operand in enumerate(operands):
                    self.write(8 * i + 8, operand)
                self.assertEqual(self.launch(f"case_{number}"), 0)
                self.assertEqual(f"{self.read(0, size):x}", f"{expected:x}", f"{name} of {[hex(operand) for operand in operands]}")
                checked += 1
        self.assertGreater(checked, 150)

    def test_a_carry_goes_to_the_next_addition(self):
        self.write(0, 2**63 + 1)
        self.assertEqual(self.launch("carry"), 0)
        self.assertEqual((self.read(0, 8), self.read(8, 8)), (2, 6))
        self.write(0, 2**62)
        self.assertEqual(self.launch("carry"), 0)
        self.assertEqual((self.read(0, 8), self.read(8, 8)), (2**63, 5))

    def test_a_borrow_goes_to_the_next_subtraction(self):
        for subtracted, expected in ((4, (2**64 - 1, 2**64 - 1, 8)), (3, (0, 0, 9))):
            self.write(0, subtracted)
            self.assertEqual(self.launch("borrow"), 0)
            self.assertEqual((self.read(0, 8), self.read(8, 8), self.read(16, 8)), expected)

    def test_tables_are_declared_with_their_alignment(self):
        # Else a compiler expects arrays of 16 bytes at multiples of 16, and takes x | 4 for x + 4.
        texts = [path.read_text(encoding="utf-8") for path in pathlib.Path(self.folder.name).rglob("*.cpp")]
        declared = [line for text in texts for line in text.split("\n") if "u8 ntable" in line]
        self.assertGreaterEqual(len(declared), 2)
        for line in declared:
            self.assertIn("u8 ntable alignas(2)[4]", line)

    def test_vectors_and_signs(self):
        self.write(0, 0xAABB1122)
        for i in range(4):
            self.write(16 + 4 * i, 100 + i, 4)
        self.assertEqual(self.launch("vectors"), 0)
        self.assertEqual(self.read(0, 4), 0x00BB00AA)
        self.assertEqual((self.read(8, 4), self.read(12, 4)), (0x12345678, 0x90ABCDEF))
        self.assertEqual([self.read(32 + 4 * i, 4) for i in range(4)], [103, 102, 101, 100])
        self.write(0, 0x80)
        self.write(4, 2**32 - 2, 4)
        self.assertEqual(self.launch("sign_of_loads"), 0)
        self.assertEqual((self.read(16, 2), self.read(18, 2), self.read(24, 8)), (0xFF80, 0x80, 2**64 - 2))

    def test_threads_have_numbers_and_add_together(self):
        self.write(0, 0)
        self.assertEqual(self.launch("numbers", 5000), 0)
        self.assertEqual(self.read(0, 4), 5000)
        self.assertEqual([self.read(4 + 4 * i, 4) for i in range(5000)], list(range(5000)))

    def test_local_memory_has_no_values_at_first(self):
        self.assertEqual(self.launch("local_memory"), 0)
        self.assertEqual((self.read(0, 4), self.read(4, 4), self.read(8, 8)), (7, 0xFEFEFEFE, 0))

    def test_calls_constants_loops_and_exchanges(self):
        self.assertEqual(self.launch("call"), 0)
        self.assertEqual(self.read(0, 8), 40 << 32 | (0x3F800000 + 40))
        self.assertEqual(self.launch("constants"), 0)
        self.assertEqual((self.read(0, 2), self.read(2, 2)), (0x0403, 2))
        self.assertEqual(self.launch("loop"), 0)
        self.assertEqual(self.read(0, 4), 45)
        self.write(0, 5)
        self.assertEqual(self.launch("exchange"), 0)
        self.assertEqual((self.read(0, 8), self.read(8, 8)), (15, 9))

    def test_faults_end_the_launch(self):
        for name, (_, words) in FAULTS.items():
            with tempfile.TemporaryFile() as printed:
                standard_error = os.dup(2)
                os.dup2(printed.fileno(), 2)
                status = self.launch(name)
                os.dup2(standard_error, 2)
                os.close(standard_error)
                printed.seek(0)
                text = printed.read().decode()
            self.assertEqual(status, 719, name)
            self.assertIn(words, text, name)
            self.assertTrue(text.startswith(f"kernels.ptx: {name}, thread 0: "), text)
        self.assertEqual(self.launch("nowhere"), 500)

    def test_blocks_above_the_launch_bounds_are_refused(self):
        self.assertEqual(self.launch("bounded", 100, 32), 0)
        self.assertEqual(self.launch("bounded", 100, 33), 1)

    def test_ways_meet_at_immediate_postdominators(self):
        self.assertEqual(immediate_postdominators([[1, 2], [3], [3], [4]]), [3, 3, 3, 4])  # two ways
        self.assertEqual(immediate_postdominators([[1], [2, 3], [1], [4]]), [1, 3, 1, 4])  # a loop around 1 and 2
        self.assertEqual(immediate_postdominators([[1], [2, 3], [1, 3], [4]]), [1, 3, 3, 4])  # that also ends in the middle
        self.assertEqual(immediate_postdominators([[1, 2], [3], [4], [4]]), [4, 3, 4, 4])  # a return
        self.assertEqual(immediate_postdominators([[1, 2], [1], [3]]), [2, 3, 3])  # a way without an end does not count

    def test_blocks_and_their_meetings_are_those_of_the_text(self):
        text = (pathlib.Path(self.folder.name) / "part_0.cpp").read_text(encoding="utf-8")
        # What all kernels begin with, before the loop, in it, behind it, and the return.
        self.assertIn('blocks[] = {8, 2, 4, 1, 1};\nstatic constexpr u32 meetings[] = {4, 2, 3, 4, 5};\nstatic constexpr Function function{"loop",', text)
        # A call ends a block, and the next one follows.
        self.assertIn('blocks[] = {8, 3, 2, 1};\nstatic constexpr u32 meetings[] = {3, 2, 3, 4};\nstatic constexpr Function function{"call",', text)

    def test_unknown_text_is_refused(self):
        for body, words in REFUSED.items():
            with tempfile.TemporaryDirectory() as folder:
                done = translate(pathlib.Path(folder), kernel("refused", body))
            self.assertEqual(done.returncode, 0 if words is None else 1, body)
            if words is not None:
                self.assertIn(words, done.stderr, body)
                self.assertIn("line ", done.stderr, body)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    CLANG, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
