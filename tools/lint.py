#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Everything ./dev lint checks. Names each check that failed; exit code 1 if any did.

    lint.py [--all] [--fix] [--jobs N] [--build FOLDER]

Layers, links of targets, text checks (lengths of files and functions, names of files), formatting (clang-format 14),
spelling (codespell), static analysis (clang-tidy 14). Analysis is slow, so a file that was clean is analysed again only
after it, a header of ours that it includes, or .clang-tidy has changed; --all analyses every file. --fix formats in
place.
"""
import argparse
import concurrent.futures
import hashlib
import json
import pathlib
import re
import subprocess
import sys

k_root = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(k_root / "tools"))
import check_text  # noqa: E402

k_folders = ("src", "include", "cli", "viewer", "python", "bench", "tests", "microbench", "examples")
k_include = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
# Words that codespell takes for misspelt: a level of detail, a misspelling that a test is about, a material statement,
# GLSL, d-dimensional, radiometry, what stands still, a wooden box.
k_words = "lod,sise,fo,nd,inout,exitance,statics,crate"


def run(*command, **more) -> subprocess.CompletedProcess:
    return subprocess.run([str(part) for part in command], cwd=k_root, capture_output=True, text=True, **more)


def own_headers(file: pathlib.Path, seen: dict[pathlib.Path, bytes]) -> None:
    """Collects the file and all headers of ours that it includes, with their content."""
    if file in seen:
        return
    seen[file] = file.read_bytes()
    for name in k_include.findall(seen[file].decode("utf-8", "replace")):
        for base in (file.parent, k_root / "src", k_root / "include", k_root / "tests", k_root):
            if (base / name).is_file():
                own_headers((base / name).resolve(), seen)
                break


def fingerprint(file: pathlib.Path, command: str) -> str:
    """Of everything that the analysis of one file depends on, the system's headers apart."""
    seen: dict[pathlib.Path, bytes] = {}
    own_headers(file, seen)
    content = hashlib.sha256(command.encode() + (k_root / ".clang-tidy").read_bytes())
    for path in sorted(seen):
        content.update(str(path.relative_to(k_root)).encode() + b"\0" + seen[path] + b"\0")
    return content.hexdigest()


def check_format(files, fix) -> list[str]:
    if fix:
        run("clang-format-14", "-i", *files)
        return []
    result = run("clang-format-14", "--dry-run", "--Werror", *files)
    return [line for line in result.stderr.splitlines() if " error: " in line or " warning: " in line]


def check_tidy(build: pathlib.Path, everything: bool, jobs: int) -> list[str]:
    stamps = build / "lint"
    stamps.mkdir(exist_ok=True)
    todo = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = pathlib.Path(entry["directory"], entry["file"]).resolve()
        if not file.is_relative_to(k_root) or file.relative_to(k_root).parts[0] not in k_folders:
            continue
        stamp = stamps / file.relative_to(k_root).as_posix().replace("/", "__")
        print_of = fingerprint(file, entry["command"])
        if everything or not stamp.exists() or stamp.read_text() != print_of:
            todo.append((file, stamp, print_of))

    def analyse(item) -> list[str]:
        file, stamp, print_of = item
        # Flags of the other compiler that this one does not know are none of its business.
        result = run("clang-tidy-14", "--quiet", "-p", build, "--extra-arg=-Wno-unknown-warning-option", file)
        if result.returncode == 0:
            stamp.write_text(print_of)
            return []
        stamp.unlink(missing_ok=True)
        wanted = [line for line in result.stdout.splitlines() if ": error: " in line or ": warning: " in line]
        return wanted or [f"{file}: clang-tidy failed: {(result.stderr or result.stdout)[-400:]}"]

    print(f"lint: analysing {len(todo)} files", flush=True)
    found: set[str] = set()   # a header's fault is found from every file that includes it
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for done, lines in enumerate(pool.map(analyse, todo), 1):
            for line in sorted(set(lines) - found):   # at once: all files take most of an hour
                print(line, flush=True)
            found.update(lines)
            if done % 20 == 0:
                print(f"lint: {done} of {len(todo)} files analysed", flush=True)
    return [f"lint: {len(found)} faults"] if found else []


def main() -> int:
    parser = argparse.ArgumentParser(description="checks the sources")
    parser.add_argument("--all", action="store_true", help="analyse every file")
    parser.add_argument("--fix", action="store_true", help="format in place")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--build", type=pathlib.Path, default=k_root / "build" / "release")
    arguments = parser.parse_args()

    files = [path.relative_to(k_root) for path in check_text.repository_files(k_root) if path.is_file()]
    sources = [path for path in files if path.suffix in {".h", ".cpp"} and path.parts[0] in k_folders]
    prose = [path for path in files if path.suffix in {".h", ".cpp", ".md", ".py", ".sh", ".cmake", ".txt"} or path.name == "dev"]

    checks = {
        "layers": lambda: run(sys.executable, "tools/check_layers.py"),
        "targets": lambda: run(sys.executable, "tools/check_targets.py", arguments.build / "link_graph.txt"),
        "text": lambda: run(sys.executable, "tools/check_text.py"),
        "words": lambda: run(sys.executable, "tools/check_words.py"),
        "spelling": lambda: run("codespell", "--quiet-level=2", f"--ignore-words-list={k_words}", *prose),
        "formatting": lambda: check_format(sources, arguments.fix),
        "analysis": lambda: check_tidy(arguments.build, arguments.all, arguments.jobs),
    }
    failed = []
    for name, check in checks.items():
        result = check()
        if isinstance(result, subprocess.CompletedProcess):
            result = (result.stdout + result.stderr).splitlines() if result.returncode else []
        for line in result:
            print(line)
        print(f"lint: {name}: {'FAILED' if result else 'ok'}", flush=True)
        if result:
            failed.append(name)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
