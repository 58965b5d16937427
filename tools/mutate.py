#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts small mistakes into a copy of the code, one at a time, and shows which tests find them.

    tools/mutate.py                   # all mistakes of tools/mutations.py, in build/mutations
    tools/mutate.py --only shading    # those whose name or technique contains a word
    tools/mutate.py --check           # compares the table with the tree, and builds nothing
    tools/mutate.py --report FILE.md  # writes what the last runs found, as a table

The tree is copied to build/mutations/tree, so that nothing in the checkout changes. Results are kept in
build/mutations/results.json, and a mistake that was judged with the same row, file and tests is not judged again
(--again judges it again).

The code must build without mistakes, and every named test must pass, before the first mistake is put in. A mistake is
found if a named test fails, crashes or takes too long. It survives if all of them pass; --wide then runs all tests of
the programs that were named, to find out whether another test finds it.

Exit code 1: a mistake survived, or could not be judged. 2: the table does not fit the tree.
"""
import argparse
import fnmatch
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from mutations import MUTATIONS  # noqa: E402

SOURCE = Path(__file__).resolve().parent.parent
PROGRAMS = ("unit", "property", "crosscheck", "cli", "hostile")
EXIT_SURVIVED, EXIT_TABLE = 1, 2
KILLED, SURVIVED, NO_BUILD, SKIPPED = "killed", "survived", "did not build", "tests skipped"
# Seconds that a run of tests may take: of processor time, because the machine may be busy, and by the clock.
PATIENCE, LONGEST = 600, 3600


def say(text):
    print(text, flush=True)


def tests_of(program):
    """The names of a program's tests, as its sources have them."""
    found = []
    for file in sorted((SOURCE / "tests" / program).glob("*_test.cpp")):
        found += [f"{suite}.{name}" for suite, name in
                  re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", file.read_text(), re.M)]
    return found


def faults_of_table():
    """What of the table does not fit the tree: texts that do not occur exactly once, tests that do not exist."""
    faults, names, tests = [], set(), {}
    texts = {}
    for mutation in MUTATIONS:
        if mutation.name in names:
            faults.append(f"{mutation.name}: a second row of this name")
        names.add(mutation.name)
        if not mutation.tests:
            faults.append(f"{mutation.name}: names no test")
        for test in mutation.tests:
            program, *patterns = test.split(":")
            if program == "ctest":
                continue
            if program not in PROGRAMS:
                faults.append(f"{mutation.name}: no test program '{program}'")
                continue
            known = tests.setdefault(program, tests_of(program))
            faults += [f"{mutation.name}: no test of {program} is named {pattern}" for pattern in patterns
                       if not fnmatch.filter(known, pattern)]
        try:
            text = texts.setdefault(mutation.file, (SOURCE / mutation.file).read_text())
        except OSError:
            faults.append(f"{mutation.name}: {mutation.file} does not exist")
            continue
        for original, replacement in mutation.edits:
            count = text.count(original)
            if count != 1:
                faults.append(f"{mutation.name}: original text not found once but {count} times in {mutation.file}: "
                              f"{original.strip().splitlines()[0]}")
            if original == replacement:
                faults.append(f"{mutation.name}: changes nothing")
    return faults


def mutated(mutation, text):
    for original, replacement in mutation.edits:
        text = text.replace(original, replacement, 1)
    return text


def copy_tree(to):
    """Copies what the checkout has, touching only files that differ, so that little is built again."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=SOURCE,
                            check=True, capture_output=True).stdout.decode()
    wanted = {name for name in listed.split("\0") if name and (SOURCE / name).is_file()}
    for name in wanted:
        source, copy = SOURCE / name, to / name
        data = source.read_bytes()
        if copy.is_file() and copy.read_bytes() == data:
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(data)
        shutil.copymode(source, copy)
    for folder, folders, files in os.walk(to):
        if Path(folder) == to:
            folders[:] = [name for name in folders if name != "build"]
        for name in files:
            if os.path.relpath(os.path.join(folder, name), to) not in wanted:
                os.unlink(os.path.join(folder, name))


class Copy:
    """A copy of the tree, and a build of it."""

    def __init__(self, folder, jobs):
        # The folders lie as in the checkout, so that ccache finds the objects of the checkout's own build.
        self.tree, self.build, self.jobs = folder / "tree", folder / "tree/build/release", jobs
        self.tree.mkdir(parents=True, exist_ok=True)
        copy_tree(self.tree)
        self.environment = dict(os.environ, GNOMON_VULKAN_VALIDATION="1")
        scenes = self.environment.get("GNOMON_SCENES")
        if not scenes and (SOURCE.parent / "shared/scenes").is_dir():
            self.environment["GNOMON_SCENES"] = str(SOURCE.parent / "shared/scenes")
        configure = ["cmake", "--preset", "release", "-DGNOMON_BENCH=OFF"]
        if shutil.which("ld.lld"):
            configure += ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld"]   # a tenth of the time of the default
        if shutil.which("ccache"):
            configure += [f"-DCMAKE_{language}_COMPILER_LAUNCHER=ccache" for language in ("C", "CXX")]
            self.environment.setdefault("CCACHE_BASEDIR", str(SOURCE.parent))
            self.environment.setdefault("CCACHE_NOHASHDIR", "1")
        subprocess.run(configure, check=True, cwd=self.tree, env=self.environment, stdout=subprocess.DEVNULL)

    def make(self, programs):
        """Builds test programs. Returns whether that succeeded, and what the compiler said."""
        targets = [f"{program}_tests" for program in programs]
        done = subprocess.run(["ninja", "-C", str(self.build), "-j", str(self.jobs), *targets], env=self.environment,
                              capture_output=True, text=True, errors="replace")
        return done.returncode == 0, done.stdout[-3000:]

    def run(self, test):
        """Runs a test. Returns the name of a test that failed (None: none did), and how many ran to their end."""
        program, pattern = test.split(":", 1)
        if program == "ctest":
            command = ["ctest", "--test-dir", str(self.build), "-R", f"^({pattern})$", "--output-on-failure"]
        else:
            # A parameterised test is named INSTANCE/SUITE.TEST/PARAMETER.
            every = ":".join(f"{p}:*/{p}:*/{p}/*" for p in pattern.split(":"))
            command = [str(self.build / "tests" / f"{program}_tests"), f"--gtest_filter={every}:-*Full.*",
                       "--gtest_fail_fast"]
        try:
            limited = ["prlimit", f"--cpu={PATIENCE}", *command] if shutil.which("prlimit") else command
            done = subprocess.run(limited, env=self.environment, capture_output=True, text=True, errors="replace",
                                  timeout=LONGEST, cwd=self.build)
            code, output = done.returncode, done.stdout
        except subprocess.TimeoutExpired as late:
            code, output = None, (late.stdout or b"").decode(errors="replace")
        if program == "ctest":
            return (pattern if code != 0 else None), output.count("Passed")
        passed = len(re.findall(r"^\[       OK \]", output, re.M))
        if code == 0:
            return None, passed
        failed = re.findall(r"^\[  FAILED  \] (\S+)", output, re.M) or re.findall(r"^\[ RUN      \] (\S+)", output, re.M)[-1:]
        too_long = code is None or code == -signal.SIGXCPU
        why = "" if code == 1 else " (too long)" if too_long else " (crash)"
        return (failed[0].rstrip(",") if failed else test) + why, passed


def programs_of(tests):
    found = []
    for test in tests:
        program = test.split(":", 1)[0]
        wanted = PROGRAMS if program == "ctest" else (program,)
        found += [p for p in wanted if p not in found]
    return found


def digest_of_code():
    """Of everything that a build or a test reads."""
    digest = hashlib.sha256()
    for folder in ("bench", "cli", "cmake", "include", "src", "tests", "viewer"):
        for file in sorted((SOURCE / folder).rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                digest.update(str(file.relative_to(SOURCE)).encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def check_unchanged(copy, chosen, passes):
    """Builds the tree as it is, and checks that all named tests pass, because a test that fails anyway finds nothing.
    Tests that passed with the same code are noted in the file `passes`, and are not run again."""
    code, known = digest_of_code(), json.loads(passes.read_text()) if passes.exists() else {}
    if known.get("code") != code:
        known = {"code": code, "tests": []}
    ok, output = copy.make(programs_of([t for m in chosen for t in m.tests]))
    if not ok:
        say(output)
        sys.exit("mutate: the tree does not build")
    faults = []
    for test in sorted({t for m in chosen for t in m.tests} - set(known["tests"])):
        began = time.monotonic()
        failed, passed = copy.run(test)
        say(f"{'as it is':14} {test} ({passed} tests, {time.monotonic() - began:.0f} s)")
        if failed:
            faults.append(f"{test}: {failed} fails without any mistake")
        elif passed == 0:
            faults.append(f"{test}: no test ran")
        else:
            known["tests"].append(test)
            passes.write_text(json.dumps(known, indent=1) + "\n")
    return faults


def judge(copy, mutation, wide):
    """Returns a state and the test that found the mistake."""
    target = copy.tree / mutation.file
    text = target.read_text()
    target.write_text(mutated(mutation, text))
    try:
        found, ran = None, 0
        for test in mutation.tests:
            programs = programs_of([test])
            ok, output = copy.make(programs)
            if not ok:
                return NO_BUILD, re.sub(r"\s+", " ", next(iter(re.findall(r"error: .*", output)), "")[:160])
            found, passed = copy.run(test)
            ran += passed
            if found:
                return KILLED, found
        if wide:
            for program in programs_of(mutation.tests):
                found, passed = copy.run(f"{program}:*")
                if found:
                    return SURVIVED, f"found by another test: {found}"
        return (SURVIVED, "") if ran else (SKIPPED, "")
    finally:
        target.write_text(text)


def key_of(mutation):
    """Changes with the row, with the mutated file, and with the code of the tests that are named."""
    digest = hashlib.sha256(repr(mutation).encode())
    digest.update((SOURCE / mutation.file).read_bytes())
    for program in programs_of(mutation.tests):
        for file in sorted((SOURCE / "tests" / program).glob("*_test.cpp")):
            if any(suite in file.read_text() for suite in re.findall(r"[A-Z]\w+", " ".join(mutation.tests))):
                digest.update(file.read_bytes())
    return digest.hexdigest()


def report(results, file):
    judged = [(m, results[m.name]) for m in MUTATIONS if m.name in results]
    killed = sum(r["state"] == KILLED for _, r in judged)
    lines = ["| technique | mistake | found by |", "|---|---|---|"]
    for mutation, result in judged:
        found = f"`{result['found']}`" if result["state"] == KILLED else f"**{result['state']}** {result['found']}"
        lines.append(f"| `{mutation.technique}` | {mutation.says} | {found} |")
    begin, end = "<!-- begin of the table -->\n", "<!-- end of the table -->\n"
    text = f"{killed} of {len(judged)} mistakes are found.\n\n" + "\n".join(lines) + "\n"
    path = Path(file)
    page = path.read_text() if path.exists() else begin + end
    if begin not in page or end not in page:
        sys.exit(f"mutate: {file} has no place for the table: {begin.strip()} and {end.strip()}")
    path.write_text(page[:page.index(begin)] + begin + text + page[page.index(end):])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the mistakes and the tests expected to find them")
    parser.add_argument("--check", action="store_true", help="compare the table with the tree, and build nothing")
    parser.add_argument("--only", metavar="WORD", action="append", help="mistakes whose name or technique has the word")
    parser.add_argument("--survivors", action="store_true", help="judge only what was not found when last judged")
    parser.add_argument("--again", action="store_true", help="judge again what was judged before")
    parser.add_argument("--wide", action="store_true", help="after a survivor, run all tests of the named programs")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without mistakes first")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilations at a time")
    parser.add_argument("--folder", type=Path, default=SOURCE / "build/mutations", help="where the copy is kept")
    parser.add_argument("--report", metavar="FILE.md", help="write the results into a page, and judge nothing")
    options = parser.parse_args()

    faults = faults_of_table()
    for fault in faults:
        say(fault)
    if faults:
        return EXIT_TABLE
    if options.check:
        return 0
    chosen = [m for m in MUTATIONS
              if not options.only or any(w in m.name or w in m.technique for w in options.only)]
    if options.list:
        for mutation in chosen:
            say(f"{mutation.technique:18} {mutation.name:26} {', '.join(mutation.tests)}\n{'':19}{mutation.says}")
        return 0
    kept = options.folder / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {}
    if options.report:
        report(results, options.report)
        return 0

    if options.survivors:
        chosen = [m for m in chosen if results.get(m.name, {}).get("state") != KILLED]
    due = [m for m in chosen if options.again or results.get(m.name, {}).get("key") != key_of(m)]
    say(f"{len(chosen)} mistakes, {len(chosen) - len(due)} of them judged before")
    if due:
        copy = Copy(options.folder, options.jobs)
        if not options.trust:
            faults = check_unchanged(copy, due, options.folder / "passes.json")
            for fault in faults:
                say(fault)
            if faults:
                return EXIT_TABLE
    # One file after the other, so that few objects are built twice.
    for mutation in sorted(due, key=lambda m: (programs_of(m.tests), m.file)):
        began = time.monotonic()
        state, found = judge(copy, mutation, options.wide)
        results[mutation.name] = {"key": key_of(mutation), "state": state, "found": found}
        kept.write_text(json.dumps(results, indent=1, sort_keys=True) + "\n")
        say(f"{state:14} {mutation.name:26} {found} ({time.monotonic() - began:.0f} s)")
    alive = [m.name for m in chosen if results[m.name]["state"] != KILLED]
    say(f"{len(chosen) - len(alive)} of {len(chosen)} mistakes are found")
    if alive:
        say("not found: " + ", ".join(alive))
    return EXIT_SURVIVED if alive else 0


if __name__ == "__main__":
    sys.exit(main())
