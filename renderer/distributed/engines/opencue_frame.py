#!/usr/bin/env python3
"""Submits a frame in parts to OpenCue: a layer of one frame per part, and a merge.

    opencue_frame.py /frames/scenes/forest.glb /frames/forest.exr --folder /frames/forest --parts 8 -- --spp 512

Arguments after -- are flags of `kindling render`. Needs pyoutline, and a show, a shot and a facility known to Cuebot; all hosts must see scene and
folder.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import getpass
import pathlib
import shlex
import sys

import outline
import outline.cuerun
from outline.modules.shell import Shell


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path, help="the merged image: .exr, .png or .kacc")
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="folder for the parts")
    parser.add_argument("--parts", type=int, default=8)
    parser.add_argument("--cores", type=int, default=4, help="per part")
    parser.add_argument("--show", default="testing")
    parser.add_argument("--shot", default="shot01")
    parser.add_argument("--retries", type=int, default=2, help="per part")
    own, flags = sys.argv[1:], []
    if "--" in own:
        own, flags = own[:own.index("--")], own[own.index("--") + 1:]
    wanted = parser.parse_args(own)
    wanted.flags = flags
    return wanted


def main():
    wanted = read_arguments()
    wanted.folder.mkdir(parents=True, exist_ok=True)

    def part_file(number):
        return shlex.quote(str(wanted.folder / f"part-{number}.kacc"))

    # Cuebot replaces #IFRAME# by the number of the OpenCue frame, which is the part's number.
    render = ["kindling", "render", shlex.quote(str(wanted.scene)), *map(shlex.quote, wanted.flags),
              "--threads", str(wanted.cores), "--part", f"#IFRAME#/{wanted.parts}",
              "--checkpoint", part_file("#IFRAME#"), "-o", part_file("#IFRAME#")]
    merge = ["kindling", "merge", *[part_file(number) for number in range(1, wanted.parts + 1)],
             "-o", shlex.quote(str(wanted.output))]

    job = outline.Outline(wanted.scene.stem, shot=wanted.shot, show=wanted.show, user=getpass.getuser())
    parts = Shell("parts", command=render, range=f"1-{wanted.parts}", chunk=1, cores=wanted.cores, overrideCores=True,
                  threadable=True)
    merged = Shell("merge", command=merge, range="1-1", chunk=1, cores=1, overrideCores=True)
    job.add_layer(parts)
    job.add_layer(merged)
    merged.depend_all(parts)
    outline.cuerun.launch(job, use_pycuerun=False, maxretries=wanted.retries)


if __name__ == "__main__":
    main()
