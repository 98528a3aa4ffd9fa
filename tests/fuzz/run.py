#!/usr/bin/env python3
"""Runs the fuzzing harnesses, some at a time, and prints a table with the work of each.

    run.py BUILD [--seconds N] [--kind KIND]... [--corpus FOLDER] [--jobs N] [--findings FOLDER]

BUILD is a build folder with KINDLING_BUILD_FUZZ, build/fuzz for example. Inputs that reach new code stay in FOLDER/KIND, so that the
next run begins with them. After a finding a harness starts again, for the rest of its time. An input that took too long runs once
more, and is a finding only if it takes as long of a processor. Exit code 0: nothing was found; 1: the inputs are in the folder of
findings; 2: a harness cannot run.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
MAX_FINDINGS = 20  # of one harness and run
INPUT_SECONDS = 30  # for one input, before it counts as a hang
START_SECONDS = 120  # beyond its time: reading the corpus, and symbols of a finding
# An image of a scene may take 1 GiB, the importer's limit on pixels. libFuzzer looks for each
# feature of an input in its list of rare ones. With the default, which calls a feature rare up to
# its 255th input, that takes half of the time of harnesses with thousands of features.
FLAGS = ["-entropic_feature_frequency_threshold=8", "-rss_limit_mb=3072", "-malloc_limit_mb=1100", "-max_len=65536",
         f"-timeout={INPUT_SECONDS}", "-print_final_stats=1"]


class Outcome:
    """The sums of all runs of one harness."""

    def __init__(self, kind):
        self.kind = kind
        self.executions = 0
        self.seconds = 0.0
        self.processor_seconds = 0.0  # less than `seconds` where other programs use the machine
        self.covered = 0
        self.edges = 0
        self.inputs = 0
        self.findings = []
        self.error = ""

    def row(self):
        rate = f"{self.executions / self.seconds:.0f}" if self.seconds > 0 else "-"
        coverage = f"{self.covered} of {self.edges} ({100 * self.covered / self.edges:.0f} %)" if self.edges else "-"
        found = self.error or len(self.findings)
        return f"| {self.kind} | {self.seconds:.0f} | {self.processor_seconds:.0f} | {self.executions} | {rate} | {coverage} | {self.inputs} | {found} |"


def read_log(outcome, log):
    """Adds what a harness printed to its outcome. Returns the summary of a finding, or an empty text."""
    executions = re.findall(r"^stat::number_of_executed_units:\s*(\d+)", log, re.MULTILINE)
    running = re.findall(r"^#(\d+)\s", log, re.MULTILINE)
    outcome.executions += int((executions or running or ["0"])[-1])
    tables = re.findall(r"Loaded \d+ PC tables \((\d+) PCs\)", log)
    outcome.edges = max([outcome.edges, *map(int, tables)])
    covered = re.findall(r"\bcov: (\d+)", log)
    outcome.covered = max([outcome.covered, *map(int, covered)])
    summary = re.findall(r"^(?:SUMMARY|finding): .*$|runtime error: .*$", log, re.MULTILINE)
    return summary[0] if summary else ""


def run_process(command, environment, limit_s, folder):
    """Runs a command. Returns its exit code (None if it was killed after `limit_s`), its messages and its processor time."""
    with tempfile.TemporaryFile(dir=folder) as messages:
        process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=messages)
        end, killed, pid = time.monotonic() + limit_s, False, 0
        while pid == 0:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid == 0 and not killed and time.monotonic() > end:
                killed = True
                process.kill()
            time.sleep(0 if pid else 0.05)
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        log = messages.read().decode(errors="replace")
    return None if killed else process.returncode, log, usage.ru_utime + usage.ru_stime


def is_slow(program, file, environment, folder):
    """Runs one input again. Returns True if it fails, takes INPUT_SECONDS of a processor, or does not end in twenty times as long: on a
    busy machine libFuzzer's limit, which is of real time, is also reached by inputs that had to wait for a processor."""
    command = [str(program), str(file), f"-timeout={20 * INPUT_SECONDS}", *(flag for flag in FLAGS if not flag.startswith("-timeout"))]
    code, _, processor_seconds = run_process(command, environment, 20 * INPUT_SECONDS, folder)
    return code != 0 or processor_seconds >= INPUT_SECONDS


def run_harness(program, kind, corpus, seeds, findings, seconds, folder):
    """Runs one harness for so many seconds in all. Returns its Outcome."""
    outcome = Outcome(kind)
    corpus.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, TMPDIR=str(folder))
    environment.setdefault("UBSAN_OPTIONS", "print_stacktrace=1")
    environment.setdefault("ASAN_OPTIONS", "detect_leaks=1:max_allocation_size_mb=2048")
    if symbolizer := shutil.which("llvm-symbolizer-14") or shutil.which("llvm-symbolizer"):
        environment.setdefault("ASAN_SYMBOLIZER_PATH", symbolizer)
    dictionary = HERE / "dictionaries" / f"{kind}.dict"
    while outcome.seconds < seconds and len(outcome.findings) < MAX_FINDINGS:
        left = max(1, round(seconds - outcome.seconds))
        prefix = findings / f"{kind}-{len(outcome.findings)}-"
        command = [program, corpus, *([seeds] if seeds.is_dir() else []), *FLAGS, f"-max_total_time={left}", f"-artifact_prefix={prefix}",
                   f"-seed={int(time.time()) % 1000000 + 1}", *([f"-dict={dictionary}"] if dictionary.exists() else [])]
        start = time.monotonic()
        code, log, processor_seconds = run_process(list(map(str, command)), environment, left + INPUT_SECONDS + START_SECONDS, folder)
        if code is None:
            log += "\nSUMMARY: the harness does not end\n"
        outcome.seconds += time.monotonic() - start
        outcome.processor_seconds += processor_seconds
        summary = read_log(outcome, log)
        if code == 0:
            break
        if not summary and not list(findings.glob(prefix.name + "*")):
            outcome.error = (log.strip().splitlines() or ["it ended without a word"])[-1]
            break
        slow = list(findings.glob(f"{prefix.name}timeout-*"))
        if slow and "libFuzzer: timeout" in summary and not is_slow(program, slow[0], environment, folder):
            slow[0].unlink()
            continue
        outcome.findings.append(summary or "it ended without a word")
        (findings / f"{prefix.name}log.txt").write_text(log[-100000:])
    outcome.inputs = sum(1 for _ in corpus.iterdir())
    return outcome


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--seconds", type=float, default=60, help="for each harness [%(default)s]")
    parser.add_argument("--kind", action="append", default=[], help="one harness; may be repeated [all that are built]")
    parser.add_argument("--corpus", type=Path, help="inputs to begin with and to add to [BUILD/corpus]")
    parser.add_argument("--findings", type=Path, help="where inputs and logs of findings go [BUILD/findings]")
    parser.add_argument("--jobs", type=int, default=1, help="harnesses at a time [%(default)s]")
    options = parser.parse_args()
    programs = options.build / "tests" / "fuzz"
    built = {path.name.removeprefix("fuzz_"): path for path in sorted(programs.glob("fuzz_*"))
             if path.is_file() and os.access(path, os.X_OK) and not path.name.startswith("fuzz_seeds_")}
    kinds = options.kind or list(built)
    for kind in kinds:
        if kind not in built:
            parser.error(f"--kind: no harness '{kind}' in {programs}; it has {', '.join(built) or 'none'}")
    if not kinds:
        parser.error(f"{programs} has no harnesses; build them: cmake --preset fuzz && cmake --build --preset fuzz")
    corpus, findings = options.corpus or options.build / "corpus", options.findings or options.build / "findings"
    findings.mkdir(parents=True, exist_ok=True)
    memory = Path("/dev/shm")  # files in memory are read faster
    with tempfile.TemporaryDirectory(dir=memory if os.access(memory, os.W_OK) else None) as folder:
        seeds = Path(folder) / "seeds"
        chosen = [word for kind in kinds for word in ("--only", kind)]
        subprocess.run([sys.executable, HERE / "make_seeds.py", seeds, "--programs", programs, *chosen], check=True)
        with ThreadPoolExecutor(options.jobs) as pool:
            outcomes = list(pool.map(lambda kind: run_harness(built[kind].resolve(), kind, (corpus / kind).resolve(), seeds / kind,
                                                              findings.resolve(), options.seconds, folder), kinds))
    print("\n| harness | seconds | of a processor | executions | per second | edges covered | inputs kept | findings |\n|---|---|---|---|---|---|---|---|")
    for outcome in outcomes:
        print(outcome.row())
    for outcome in outcomes:
        for number, summary in enumerate(outcome.findings):
            print(f"FINDING {outcome.kind}: {summary} ({findings}/{outcome.kind}-{number}-*)")
    if any(outcome.error for outcome in outcomes):
        return 2
    return 1 if any(outcome.findings for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
