#!/usr/bin/env python3
"""Imports every glTF file below some folders, and mutants of them, with a (sanitized) load_check.

    check_assets.py LOAD_CHECK FOLDER... [--mutants N] [--seed S]

Fails if load_check crashes, hangs, leaks, or prints anything but one line for each file; if a strict load accepts a file that the
glTF validator's report beside it (FILE.report.json) calls invalid for a reason not listed as harmless below; and if a load with
repairs refuses a file that a strict one accepts.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

# Errors of the validator that leave the image well defined, by reason.
HARMLESS = {
    "declared bounds are not used": [
        "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "ACCESSOR_MAX_MISMATCH",
        "ACCESSOR_MIN_MISMATCH", "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
        "ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS"],
    "values are repaired while they are read": [
        "ACCESSOR_INVALID_FLOAT", "ACCESSOR_INVALID_IBM", "ACCESSOR_INVALID_SIGN", "ACCESSOR_VECTOR3_NON_UNIT",
        "ACCESSOR_NON_CLAMPED", "ACCESSOR_WEIGHTS_NEGATIVE", "ACCESSOR_WEIGHTS_NON_NORMALIZED", "ROTATION_NON_UNIT",
        "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION"],
    "alignment and hints to a GPU have no effect": [
        "ACCESSOR_OFFSET_ALIGNMENT", "ACCESSOR_TOTAL_OFFSET_ALIGNMENT", "ACCESSOR_MATRIX_ALIGNMENT",
        "MESH_PRIMITIVE_ACCESSOR_UNALIGNED", "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", "GLB_CHUNK_LENGTH_UNALIGNED",
        "BUFFER_VIEW_TARGET_OVERRIDE", "BUFFER_VIEW_INVALID_BYTE_STRIDE", "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE",
        "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE", "ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE",
        "SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE", "IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE"],
    "an index with a vertex is valid": ["ACCESSOR_INDEX_PRIMITIVE_RESTART"],
    "points are not rendered; triangles with these joints are refused or repaired": [
        "ACCESSOR_JOINTS_INDEX_OOB", "ACCESSOR_JOINTS_INDEX_DUPLICATE"],
    "the last channel is used": ["ANIMATION_DUPLICATE_TARGETS"],
    "MIME types are ignored, images are recognized by their bytes": [
        "BUFFER_DATA_URI_MIME_TYPE_INVALID", "IMAGE_MIME_TYPE_INVALID", "IMAGE_NON_ENABLED_MIME_TYPE",
        "TEXTURE_INVALID_IMAGE_MIME_TYPE"],
    "an unreadable image is a warning": [
        "IMAGE_DATA_INVALID", "IMAGE_UNEXPECTED_EOS", "IO_ERROR", "INVALID_URI"],
    "empty and duplicate elements have no effect": ["EMPTY_ENTITY", "DUPLICATE_ELEMENTS"],
    "a byte order mark is skipped": ["INVALID_JSON"],
    "unknown attributes, extensions and paths have no effect": [
        "MESH_PRIMITIVE_INVALID_ATTRIBUTE", "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT",
        "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", "MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR",
        "UNEXPECTED_EXTENSION_OBJECT", "UNDECLARED_EXTENSION", "NON_REQUIRED_EXTENSION",
        "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH", "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE",
        "PATTERN_MISMATCH"],
    "missing texture coordinates read (0, 0), missing tangents are computed": [
        "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", "MESH_PRIMITIVE_NO_TANGENT_SPACE"],
    "joints may be anywhere in the tree, 'skeleton' is ignored": [
        "NODE_SKIN_NO_SCENE", "SKIN_NO_COMMON_ROOT", "SKIN_SKELETON_INVALID"],
    "features without a target have no effect": ["NODE_SKIN_WITH_NON_SKINNED_MESH", "UNSATISFIED_DEPENDENCY"],
    "the camera's type decides": ["ONE_OF_MISMATCH"],
    "deep JSON exhausts the stack of the validator alone": ["STACK_OVERFLOW"],
}
# Extension objects whose faults have no effect.
UNREAD = ["KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion", "KHR_materials_iridescence",
          "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen", "KHR_materials_transmission",
          "KHR_materials_variants", "KHR_materials_volume"]
# An asset whose invalid parts belong to unknown extensions and extras.
HARMLESS_FILES = {"root/extensions_non_objects.gltf"}
HARMLESS_CODES = {code for codes in HARMLESS.values() for code in codes}

SECONDS_PER_FILE = 20


def run(load_check, files, strict=True):
    """Returns load_check's lines for the files; raises RuntimeError if it fails."""
    environment = dict(os.environ)
    environment.setdefault("ASAN_OPTIONS", "max_allocation_size_mb=2048:detect_leaks=1")
    environment.setdefault("UBSAN_OPTIONS", "print_stacktrace=1")
    try:
        done = subprocess.run([load_check] + (["-s"] if strict else []) + files, capture_output=True, env=environment,
                              timeout=SECONDS_PER_FILE + 2 * len(files))
    except subprocess.TimeoutExpired:
        raise RuntimeError("hangs") from None
    lines = done.stdout.decode(errors="replace").splitlines()
    if done.returncode != 0 or done.stderr:
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr.decode(errors='replace')[-3000:]}")
    if len(lines) != len(files):
        raise RuntimeError(f"{len(lines)} lines for {len(files)} files")
    for line in lines:
        if not line.startswith(("OK ", "ERROR ")):
            raise RuntimeError(f"unexpected line: {line}")
    return lines


def run_each(load_check, files, problems, strict=True):
    """Like run(), but finds the file that fails, records it, and continues with the others."""
    try:
        return run(load_check, files, strict)
    except RuntimeError as error:
        if len(files) == 1:
            problems.append(f"{files[0]}: {error}")
            copy = os.path.join(tempfile.gettempdir(), "failing_" + os.path.basename(files[0]))
            shutil.copy(files[0], copy)
            return ["FAILED"]
    middle = len(files) // 2
    return run_each(load_check, files[:middle], problems, strict) + run_each(load_check, files[middle:], problems, strict)


def is_harmless(message):
    """Whether a message of the validator is no error, or one that leaves the image well defined."""
    pointer = message.get("pointer", "")
    if message["severity"] != 0 or message["code"] in HARMLESS_CODES or any("/extensions/" + name in pointer for name in UNREAD):
        return True
    # A missing image of a texture counts as unreadable; an emission above 1 is used unchanged.
    return (message["code"] == "UNRESOLVED_REFERENCE" and pointer.endswith("/source")) or (
        message["code"] == "VALUE_NOT_IN_RANGE" and "/emissiveFactor/" in pointer and not message["message"].startswith("Value -"))


def unexplained(file):
    """Returns the error codes of the validator's report that are not harmless."""
    report = file + ".report.json"
    if not os.path.exists(report) or any(file.endswith(name) for name in HARMLESS_FILES):
        return []
    with open(report, encoding="utf-8") as stream:
        messages = json.load(stream)["issues"]["messages"]
    return sorted({message["code"] for message in messages if not is_harmless(message)})


def mutate_text(text, generator):
    """Changes numbers, indices and words; the result usually remains JSON."""
    kind = generator.randrange(4)
    if kind == 0:
        return mutate_bytes(text, generator)
    digits = [match.span() for match in re.finditer(rb"-?[0-9]+(?:[.][0-9]+)?", text)]
    words = [match.span() for match in re.finditer(rb'"[A-Za-z_0-9]+"', text)]
    for _ in range(generator.randrange(1, 4)):
        spans = digits if kind != 1 or not words else words
        if not spans:
            break
        start, end = generator.choice(spans)
        if spans is words:
            other = generator.choice(words)
            new = text[other[0]:other[1]]
        else:
            new = generator.choice([b"0", b"1", b"2", b"3", b"5", b"-1", b"4294967295", b"1e30", b"2147483648", b"65535",
                                    b"0.5", b"5121", b"5123", b"5126", b"[]", b"{}", b"null", b'"x"', b"1e-30"])
        text = text[:start] + new + text[end:]
        digits = [match.span() for match in re.finditer(rb"-?[0-9]+(?:[.][0-9]+)?", text)]
        words = [match.span() for match in re.finditer(rb'"[A-Za-z_0-9]+"', text)]
    return text


def mutate_bytes(data, generator):
    data = bytearray(data)
    kind = generator.randrange(5)
    if kind == 0 and len(data) > 1:
        del data[generator.randrange(len(data)):]
    elif kind == 1 and len(data) > 1:
        start = generator.randrange(len(data))
        del data[start:start + generator.randrange(1, 64)]
    else:
        # Half of the changes are near the start, in headers.
        reach = len(data) if generator.random() < 0.5 else min(len(data), 4096)
        for _ in range(generator.randrange(1, 64 if kind == 4 else 5)):
            if reach:
                data[generator.randrange(reach)] = generator.randrange(256)
    return bytes(data)


def mutate(data, generator):
    """Mutates any file; a .glb usually remains a container with one changed chunk."""
    if data[:4] != b"glTF" or len(data) < 20 or generator.random() < 0.2:
        return mutate_text(data, generator) if data[:1] == b"{" else mutate_bytes(data, generator)
    length = int.from_bytes(data[12:16], "little")
    text, rest = data[20:20 + length], data[20 + length:]
    if generator.random() < 0.5 and len(rest) > 8:
        rest = rest[:8] + mutate_bytes(rest[8:], generator)
        rest = (len(rest) - 8).to_bytes(4, "little") + rest[4:]
    else:
        text = mutate_text(text, generator)
    body = len(text).to_bytes(4, "little") + data[16:20] + text + rest
    return data[:8] + (12 + len(body)).to_bytes(4, "little") + body


def mutants(files, count, generator, folder):
    """Copies model folders, and adds mutated files beside the originals."""
    names = []
    copies = {}
    small = [file for file in files if os.path.getsize(file) < 4000000]
    for number in range(count):
        file = generator.choice(small)
        source = os.path.dirname(file)
        if source not in copies:
            copies[source] = os.path.join(folder, str(len(copies)))
            os.mkdir(copies[source])
            for name in os.listdir(source):
                if os.path.isfile(os.path.join(source, name)) and not name.endswith(".report.json"):
                    shutil.copy(os.path.join(source, name), copies[source])
        with open(file, "rb") as stream:
            data = stream.read()
        stem, extension = os.path.splitext(os.path.basename(file))
        side = [name for name in os.listdir(source) if name.endswith((".bin", ".png", ".jpg", ".webp", ".ktx2")) and name.encode() in data]
        if extension == ".gltf" and side and generator.random() < 0.3:
            name = generator.choice(side)
            with open(os.path.join(source, name), "rb") as stream:
                broken = mutate(stream.read(), generator)
            with open(os.path.join(copies[source], f"m{number}_{name}"), "wb") as stream:
                stream.write(broken)
            data = data.replace(name.encode(), f"m{number}_{name}".encode())
        else:
            data = mutate(data, generator)
        names.append(os.path.join(copies[source], f"{stem}_m{number}{extension}"))
        with open(names[-1], "wb") as stream:
            stream.write(data)
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("load_check")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--mutants", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()

    files = sorted(os.path.join(path, name) for folder in options.folders for path, _, names in os.walk(folder)
                   for name in names if name.endswith((".gltf", ".glb")))
    problems = []
    lines = run_each(options.load_check, files, problems)
    repaired = run_each(options.load_check, files, problems, strict=False)
    accepted = sum(line.startswith("OK ") for line in lines)
    for file, strict, lenient in zip(files, lines, repaired):
        if strict.startswith("OK ") and not lenient.startswith("OK "):
            problems.append(f"{file}: repairs refuse it: {lenient}")
    for file, line in zip(files, lines):
        codes = unexplained(file)
        if line.startswith("OK ") and codes:
            problems.append(f"{file}: accepted although {', '.join(codes)}")
        if line.startswith("ERROR ") and not line.startswith("ERROR " + file + ": "):
            problems.append(f"{file}: an error that does not start with its name: {line}")
    by_repair = sum(line.startswith("OK ") for line in repaired) - accepted
    print(f"{len(files)} files: {accepted} accepted, {by_repair} repaired, {len(files) - accepted - by_repair} refused")

    if options.mutants:
        generator = random.Random(options.seed)
        with tempfile.TemporaryDirectory() as folder:
            names = mutants(files, options.mutants, generator, folder)
            lines = []
            for start in range(0, len(names), 64):
                lines += run_each(options.load_check, names[start:start + 64], problems, strict=False)
        accepted = sum(line.startswith("OK ") for line in lines)
        print(f"{len(names)} mutants (seed {options.seed}): {accepted} accepted, {len(names) - accepted} refused")

    for problem in problems:
        print("PROBLEM", problem)
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
