#!/usr/bin/env python3
"""Shares of a render by stage and by folder, from stacks (perf) or counts by line (callgrind).

Run by profile.sh."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import re
import subprocess
from collections import Counter

# Functions that identify kinds of rays: stages of the path tracer, and their calls of an
# accelerator for stacks that were cut before they reached the stage. Names of inlined functions
# lack their classes.
RAYS = [(re.compile(r"(^|::)(trace_camera_rays|intersect_camera_rays|intersect_coherent|intersect_by_packets)\b"), "rays: camera"),
        (re.compile(r"(^|::)(trace_shadows\b|occluded)"), "rays: shadow"),
        (re.compile(r"(^|::)(trace_bounces|intersect|intersect_singly|intersect_stream)\b"), "rays: bounce")]
RENDER = re.compile(r"(^|::)render_block\b")
STAGES = {  # by the folder of the innermost function listed here; renderer/base and most of sampling count for the caller
    "renderer/world": "surfaces and textures", "renderer/texture": "surfaces and textures", "renderer/bsdf": "BSDF",
    "renderer/light": "light sampling", "renderer/film": "film", "renderer/camera": "camera rays made",
    "renderer/integrator": "integrator", "renderer/session": "scheduling"}
OUTSIDE = "(before and after the render)"
ORDER = ["rays: camera", "rays: bounce", "rays: shadow", "surfaces and textures", "BSDF", "light sampling", "sampler",
         "camera rays made", "film", "integrator", "scheduling", "other"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", required=True)
    parser.add_argument("--program", required=True)
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--perf", metavar="FILE", help="of perf script -F ip,sym,dso")
    group.add_argument("--callgrind", metavar="FILE", help="with uncompressed names")
    options = parser.parse_args()
    if options.perf:
        with open(options.perf, encoding="utf-8", errors="replace") as file:
            stacks = read_stacks(file)
        stages, rooms = of_stacks(stacks, symbolize(options.program, stacks), options.root, options.program)
        print(report(stages, rooms, "samples"))
    else:
        with open(options.callgrind, encoding="utf-8", errors="replace") as file:
            stages, rooms = of_callgrind(file, options.root)
        print(report(stages, rooms, "instructions"))


def report(stages, rooms, unit):
    total = sum(count for stage, count in stages.items() if stage != OUTSIDE)
    lines = [f"{total + stages[OUTSIDE]} {unit}, {total} of them in the render.", "", f"{'stage':30} % of the render"]
    for stage in sorted(stages, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER)):
        if stage != OUTSIDE:
            lines.append(f"{stage:30} {100 * stages[stage] / max(total, 1):6.1f}")
    everything = sum(rooms.values())
    lines += ["", f"{'folder or library':30} % of all"]
    lines += [f"{room:30} {100 * count / max(everything, 1):6.1f}" for room, count in rooms.most_common() if count >= everything / 1000]
    return "\n".join(lines)


def folder_of(path, root):
    """The folder of a source file below `root`, or None."""
    path = os.path.normpath(path)
    prefix = os.path.normpath(root) + "/"
    return os.path.dirname(path[len(prefix):]) if path.startswith(prefix + "renderer/") or path.startswith(prefix + "accel/") else None


def library_of(dso):
    name = os.path.basename(dso)
    if name.startswith("libembree"):
        return "Embree"
    if re.match(r"lib(c|m|stdc\+\+|gcc_s)[.-]|ld-linux|\[vdso\]", name):
        return "libc, libm, libstdc++"
    return re.sub(r"\.so.*", "", name)


def stage_of(folder, file):
    if folder == "renderer/sampling":
        return "sampler" if os.path.basename(file).startswith("sampler") else None
    return STAGES.get(folder)


# --- perf

def read_stacks(lines):
    """For each sample the frames (address within its file, symbol, file), the innermost first."""
    stacks, stack = [], []
    for line in lines:
        frame = re.match(r"\s+([0-9a-f]+) (.*) \((.*)\)$", line.rstrip("\n"))
        if frame:
            stack.append((int(frame[1], 16), frame[2], frame[3]))
        elif stack:
            stacks.append(stack)
            stack = []
    return stacks + ([stack] if stack else [])


def symbolize(program, stacks):
    """{address: [(function, file)]} for the addresses in the program, inlined functions first."""
    program = os.path.realpath(program)
    addresses = sorted({lookup_address(frame, depth) for stack in stacks for depth, frame in enumerate(stack)
                        if os.path.realpath(frame[2]) == program})
    output = subprocess.run(["addr2line", "-a", "-f", "-i", "-C", "-e", program], input="\n".join(map(hex, addresses)),
                            stdout=subprocess.PIPE, text=True, check=True).stdout
    found, lines = {}, iter(output.splitlines())
    for line in lines:
        if re.fullmatch(r"0x[0-9a-f]{8,}", line):
            frames = found.setdefault(int(line, 16), [])
        else:
            frames.append((line, next(lines).split(":")[0]))
    return found


def lookup_address(frame, depth):
    """The address of the call of each caller: perf has the return address, which follows it."""
    return frame[0] - (1 if depth > 0 else 0)


def of_stacks(stacks, symbols, root, program):
    """Counters of the samples by stage and by folder or library."""
    stages, rooms = Counter(), Counter()
    program = os.path.realpath(program)
    for stack in stacks:
        frames = []  # (function, folder, file), the innermost first
        for depth, (address, symbol, dso) in enumerate(stack):
            if os.path.realpath(dso) == program:
                inlined = symbols.get(lookup_address((address, symbol, dso), depth), [])
                # The last is the function itself; perf has its full name.
                frames += [(symbol if i == len(inlined) - 1 else function, folder_of(file, root), file)
                           for i, (function, file) in enumerate(inlined)]
            else:
                frames.append((symbol, None, dso))
        rooms[room_of_stack(stack, frames, program)] += 1
        stages[stage_of_stack(frames)] += 1
    return stages, rooms


def room_of_stack(stack, frames, program):
    if os.path.realpath(stack[0][2]) != program:
        return library_of(stack[0][2])
    return next((folder for _, folder, _ in frames if folder), "other")


def stage_of_stack(frames):
    for function, folder, _ in reversed(frames):
        if folder and (folder.startswith("accel") or folder == "renderer/integrator"):
            for pattern, kind in RAYS:
                if pattern.search(function):
                    return kind
    if not any(RENDER.search(function) for function, _, _ in frames):
        return OUTSIDE
    return next((stage for _, folder, file in frames if folder and (stage := stage_of(folder, file))), "other")


# --- callgrind

def of_callgrind(lines, root):
    """Counters of instructions by stage and by folder. Rays count by the calls of an accelerator, everything else by the cost of its
    lines; lookups of hit filters during traversal count in both."""
    stages, rooms = Counter(), Counter()
    library = function = file = own_file = callee = ""
    in_call = False
    render_total = total = 0
    for line in lines:
        if match := re.match(r"(ob|fl|fi|fe|fn|cob|cfi|cfl|cfn|calls)=(.*)", line):
            key, value = match[1], match[2].strip()
            if key == "ob":
                library = value
            elif key in ("fl", "fi", "fe"):
                file = value
                own_file = value if key == "fl" else own_file
            elif key == "fn":
                function = value
            elif key == "cfn":
                callee = value
            elif key == "calls":
                in_call = True
        elif match := re.match(r"[-+*\d]\S* (\d+)", line):
            cost = int(match[1])
            if in_call:
                in_call = False
                if RENDER.search(callee) and not RENDER.search(function):
                    render_total += cost
                if "::accel::" not in function:
                    stages[next((kind for pattern, kind in RAYS if pattern.search(callee)), "")] += cost
                continue
            total += cost
            # Code inlined from headers of libraries belongs to the function around it.
            folder = folder_of(file, root) or folder_of(own_file, root)
            rooms[folder or (library_of(library) if ".so" in library else "other")] += cost
            stage = stage_of(folder, file) if folder else None
            if stage:
                stages[stage] += cost
    del stages[""]
    stages["other"] = max(render_total - sum(stages.values()), 0)
    stages[OUTSIDE] = total - sum(stages.values())
    return stages, rooms


if __name__ == "__main__":
    main()
