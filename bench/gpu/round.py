#!/usr/bin/env python3
"""Compares images of a GPU with the CPU's to the bit, and its times; round.sh runs it.

usage: round.py --out FOLDER [--program KINDLING] [--device NAME] [--parts NAME,...] [--seconds N] [--size WxH] [--spp N]
                [--rounds N] [--rays N] [--paper-flags FLAGS] [--peer-size WxH] [--peer-spp N]
       round.py --collect FOLDER TO       copies the scenes of FOLDER/scenes.json, with environments, into TO
--parts: of machine, start, split, speed, shootout, scaling, images, kernels, sanitizer, paper, peer, bits (all, in this order).
--seconds: no new measurement begins after that time; a third of it is reserved for bits, unless --parts is without it."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tarfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import one_round  # noqa: E402  (finds the modules of bench and tests/device)
import renderers  # noqa: E402
import same_images  # noqa: E402
from kernels import kernels  # noqa: E402
from one_round import ROOT, measured_jobs  # noqa: E402
from paper_figures import paper  # noqa: E402
from peer import peer  # noqa: E402
from sanitizer import TOOLS, sanitizer  # noqa: E402

SIZES = ("64x48", "161x97", "320x180")
AOVS = ("alpha,albedo,normal,depth,position,emission,direct,indirect,variance,samples,denoising_albedo,denoising_normal,object_id,material_id,uv,"
        "depth_nearest,position_nearest")
PASSES = ("diffuse_direct,diffuse_indirect,glossy_direct,glossy_indirect,transmission_direct,transmission_indirect,volume_direct,volume_indirect,"
          "emit,environment,diffuse_color,glossy_color,transmission_color")
# Kernels of their own split light, so they run in one of the sizes.
LAYERS = {SIZES[0]: ("--aov", f"{AOVS},{PASSES}", "--light-groups", "name", "--cryptomatte", "object,material,asset"),
          SIZES[1]: ("--aov", f"{AOVS},vector", "--path-reuse", "8", "--shutter", "0,0"),
          SIZES[2]: ("--aov", AOVS, "--direct-samples", "16", "--reflection-samples", "4")}


def collect(folder, to):
    """Copies a folder of measured scenes; environments lie beside them then."""
    entries = json.loads((folder / "scenes.json").read_text(encoding="utf-8"))
    table = to / "scenes.json"
    known = json.loads(table.read_text(encoding="utf-8")) if table.is_file() else {}
    for job in renderers.load_jobs([folder]):
        entry = {name: value for name, value in entries[job.name].items() if name != "ref"}
        if job.environment:
            entry["hdr"] = job.environment.name
            shutil.copy(job.environment, to)
        shutil.copy(job.scene, to)
        known[job.name] = entry
    table.write_text(json.dumps(known, indent=1), encoding="utf-8")


def machine(the_round):
    """Processor, GPU, driver and program."""
    processor = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")),
                     platform.machine())
    try:
        gpu = subprocess.run(["nvidia-smi", "--query-gpu=name,driver_version,memory.total", "--format=csv,noheader"], check=True,
                             capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        gpu = "nvidia-smi names none"
    version = subprocess.run([the_round.program, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    return {"processor": processor, "threads": os.cpu_count(), "gpu": gpu, "program": version}


def start(the_round):
    """Seconds of a render of one sample: with an empty cache of kernels (unless another part came first), and again."""
    scene = ROOT / "scenes" / "cornell_box.glb"
    arguments = ("render", scene, "--size", "64x64", "--spp", 1, "-o", the_round.folder / "start.png", "--quiet", "--device")
    names = ("kernels compiled", "kernels from the cache", "again")
    return {name: the_round.run(*arguments, the_round.options.device)[0] for name in names} | {
        "CPU": the_round.run(*arguments, "cpu")[0]}


def split(the_round):
    """Whether a frame that two devices share is that of one: parts that are merged, and a checkpoint that moves."""
    device, scene = the_round.options.device, ROOT / "scenes" / "interior.glb"
    common = ("--size", "160x90", "--exr-float", "--quiet")
    where = the_round.folder
    the_round.run("render", scene, *common, "--spp", 16, "-o", where / "whole.exr", "--device", "cpu")
    whole = same_images.pixels_of(where / "whole.exr")
    for number, part_device in enumerate(("cpu", device), 1):
        the_round.run("render", scene, *common, "--spp", 16, "--part", f"{number}/2", "-o", where / f"part_{number}.kacc", "--device", part_device)
    the_round.run("merge", where / "part_1.kacc", where / "part_2.kacc", "-o", where / "merged.exr", "--exr-float", "--quiet")
    answers = {"half by the CPU, half by the device": same_images.pixels_of(where / "merged.exr") == whole}

    def resumed(first, second):
        saved = where / f"{first}_{second}.kacc"
        the_round.run("render", scene, *common, "--spp", 8, "--checkpoint", saved, "-o", where / "resumed.exr", "--device", first)
        the_round.run("resume", saved, "--spp", 16, "--device", second, "--quiet")
        return same_images.pixels_of(where / "resumed.exr")

    expected = resumed("cpu", "cpu")
    for first, second in (("cpu", device), (device, "cpu")):
        answers[f"begun by {first}, ended by {second}"] = resumed(first, second) == expected
    return answers


def speed(the_round):
    """Million samples per second of the render phase, without the start of the device: medians of rounds in turn. The time of the last
    round by kernel."""
    options = the_round.options
    contestants = {options.device: (options.device, 0, options.spp), "CPU, all threads": ("cpu", 0, max(1, options.spp // 8)),
                   "CPU, two threads": ("cpu", 2, max(1, options.spp // 32))}
    rates, table = {}, the_round.found.setdefault("speed", {})
    times = the_round.found.setdefault("times", {})
    for job in measured_jobs():
        for _ in range(options.rounds):
            for name, (device, threads, spp) in contestants.items():
                if the_round.is_over():
                    return table
                _, stats = the_round.render(job, "speed", "--threads", threads, device=device, spp=spp, size=options.size)
                width, height = map(int, options.size.split("x"))
                seconds = max(stats["phases"]["render"] - stats["device"]["start_s"], 1e-9)
                rates.setdefault((job.name, name), []).append(width * height * spp / seconds * 1e-6)
                if device != "cpu":
                    nanoseconds = {kernel: use["seconds"] / (width * height * spp) * 1e9 for kernel, use in stats["device"]["kernels"].items()}
                    times[job.name] = dict(sorted(nanoseconds.items(), key=lambda kernel: -kernel[1]), all=sum(nanoseconds.values()))
        table[job.name] = {name: statistics.median(rates[job.name, name]) for name in contestants}
        the_round.save()
    return table


def shootout(the_round):
    """Million rays per second of the device and of one thread with the kd-tree and Embree, on the same rays: geometric means over the
    kinds of rays, and how many answers are not the kd-tree's."""
    table = the_round.found.setdefault("shootout", {})
    for job in measured_jobs():
        if the_round.is_over():
            break
        scene = the_round.measure("shootout", job, "--accel", "kdtree,embree", "--no-embree-calls", "--rays-per-kind", the_round.options.rays,
                                  "--repeat", 3, "--build-repeat", 1)
        rates = {accelerator["name"]: fastest_rates(accelerator) for accelerator in scene["accelerators"]}
        device = next(accelerator for accelerator in scene["accelerators"] if "device" in accelerator)
        if device["fault"]:
            raise RuntimeError(f"{job.name}: {device['name']} {device['fault']}")
        launches = fastest_rates(device, "launch")
        table[job.name] = {f"{name}, {kind}": rate[kind] for kind in ("camera", "bounce1", "shadow1") for name, rate in
                           {device["name"]: launches, **{n: r for n, r in rates.items() if n != device["name"]}}.items() if kind in rate}
        table[job.name] |= {f"{device['name']} to {name}": statistics.geometric_mean(launches[kind] / rate[kind] for kind in launches)
                            for name, rate in rates.items() if name != device["name"]}
        table[job.name] |= {"answers": device["device"]["answers"], "different": device["device"]["different"]}
        the_round.save()
    return table


def fastest_rates(accelerator, call=None):
    """The greatest million rays per second by kind of rays, of one form of call or of all."""
    rates = {}
    for row in accelerator["traversal"]:
        if call in (None, row["call"]):
            rates[row["rays"]] = max(rates.get(row["rays"], 0.0), row["mega_rays_per_s"])
    return rates


def scaling(the_round):
    """One thread, all threads, the device, and both on one frame: million samples per second; all images must be equal."""
    table = the_round.found.setdefault("scaling", {})
    for job in measured_jobs():
        if the_round.is_over():
            break
        scene = the_round.measure("scaling", job, "--accel", "kdtree", "--schedule", "tiles", "--size", "640x360", "--repeat", 2,
                                  "--spp", max(1, the_round.options.spp // 8), "--threads", f"1,{max(2, os.cpu_count())}",
                                  "--max-bounces", job.max_bounces)
        device = scene["device"]
        row = {f"{processor['threads']} thread{'s' if processor['threads'] > 1 else ''}": processor["samples_per_s"] * 1e-6
               for processor in device["alone"]["processors"]}
        row |= {"device": device["alone"]["samples_per_s"] * 1e-6, "both, start included": device["shared"]["samples_per_s"] * 1e-6,
                "start of the device, s": device["alone"]["start_s"], "share of the processor": device["shared"]["processor_share"],
                "different images": len(scene["mismatches"])}
        table[job.name] = row
        the_round.save()
    return table


def images(the_round):
    """Renders each measured scene for the eye."""
    count = 0
    with tarfile.open(the_round.options.out / "images.tar", "w") as archive:
        for job in measured_jobs():
            if the_round.is_over():
                break
            image = the_round.folder / f"{job.name}.png"
            command = renderers.kindling_command(the_round.program, job, the_round.options.spp, 0, image)[1:]
            the_round.run(*command, "--device", the_round.options.device, "--quiet")
            archive.add(image, image.name)
            count += 1
    return {"images": count}


def bits(the_round):
    """Images whose pixels differ from those of the CPU, in three sizes: with all layers and parts of the light, with shared paths, and with
    the most light samples and reflection samples. Several are rendered at the same time."""
    jobs = measured_jobs() + [renderers.Job(str(scene.relative_to(ROOT / "scenes")), scene, (320, 180), 8)
                              for scene in same_images.scenes_in(ROOT / "scenes")]
    compared, different, early = 0, [], {}

    def is_same(job, size):
        """None if there was no time."""
        if the_round.is_over():
            return None
        name = f"{job.name} {size}".replace("/", " ")
        pixels = []
        for device in ("cpu", the_round.options.device):
            image = the_round.render(job, f"{name} {device}", *LAYERS[size], device=device, spp=4, size=size)[0]
            pixels.append(same_images.pixels_of(image))
            image.unlink()
        return pixels[0] == pixels[1]

    with concurrent.futures.ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // 3)) as threads:
        answers = [(job, size, threads.submit(is_same, job, size)) for job in jobs for size in SIZES]
        for job, size, answer in answers:
            try:
                same = answer.result()
            except RuntimeError as error:  # the other images may still tell something
                different.append(f"{job.name} {size}: {error}")
                continue
            if same is None:
                early = early or {"ended early before": job.name}
            else:
                compared += 1
                if not same:
                    different.append(f"{job.name} {size}")
    return {"compared": compared, "different": different} | early


PARTS = {part.__name__: part for part in (machine, start, split, speed, shootout, scaling, images, kernels, sanitizer, paper, peer, bits)}


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--collect", nargs=2, type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--program", type=Path, default=renderers.KINDLING)
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--parts", type=lambda text: text.split(","), default=list(PARTS))
    parser.add_argument("--seconds", type=float, default=540.0)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--rays", type=int, default=1 << 18)
    parser.add_argument("--paper-flags", default="")
    parser.add_argument("--peer-size", default="640x360")
    parser.add_argument("--peer-spp", type=int, default=256)
    options = parser.parse_args()
    if not options.collect and not options.out:
        parser.error("--out is missing")
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"--parts {', '.join(sorted(unknown))}: use some of {', '.join(PARTS)}")
    return options


def main():
    options = arguments()
    if options.collect:
        collect(*options.collect)
        return 0
    options.out.mkdir(parents=True, exist_ok=True)
    options.out, options.program = options.out.resolve(), options.program.resolve()
    the_round = one_round.Round(options)
    for place, part in enumerate(options.parts):
        the_round.reserve("bits" in options.parts[place + 1:])
        try:
            the_round.found[part] = PARTS[part](the_round)
        except one_round.Skipped as reason:
            the_round.found.setdefault(part, {})["skipped"] = str(reason)
        except (RuntimeError, OSError, LookupError, ValueError) as error:  # the other parts may still tell something
            the_round.found.setdefault(part, {})["failed"] = str(error)
        page = the_round.save()
    print(page)
    shutil.rmtree(the_round.folder)
    return 1 if has_failed(the_round.found) else 0


def has_failed(found):
    """Whether a part failed, a bit differs, or the sanitizer found an error."""
    failed = any("failed" in result for result in found.values())
    failed = failed or bool(found.get("bits", {}).get("different")) or False in found.get("split", {}).values()

    def rows(part):
        return (row for row in found.get(part, {}).values() if isinstance(row, dict))

    for part, counts in (("shootout", ("different",)), ("scaling", ("different images",)), ("sanitizer", TOOLS)):
        failed = failed or any(row.get(count) for row in rows(part) for count in counts)
    return failed or any(not row["same bits"] for row in rows("paper"))


if __name__ == "__main__":
    sys.exit(main())
