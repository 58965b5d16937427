#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps retired words out of sources, documents and messages.

    check_words.py [--root ROOT] [--count]

One idea has one word, the field's own. The tables below list the words that were given up and what to say instead; they
are found as words of prose, as parts of identifiers (snake_case and CamelCase are split) and as phrases. Names that
users have in scripts keep such words: they are in the table of exceptions, with the reason.

Prints `file:line: retired word 'x': say 'y'`; exit code 1 if there is any. --count prints how many each file has.
"""
import argparse
import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_text  # noqa: E402

# Whole words, also within identifiers; the plural as well.
k_words = {
    "mover": "dynamic object",
    "picture": "image (or frame)",
    "film": "video",
    "twin": "reference implementation",
    "lamp": "light (or emitter)",
    "verb": "subcommand",
    "lifted": "promoted",
    "squeezed": "singular",
}
# How words begin.
k_stems = {"reckon": "compute"}
# Phrases, in prose (with blanks) or in identifiers (with underscores).
k_phrases = {
    "by hand": "user override",
    "asks nobody": "needs no visibility test",
    "stands alone": "has_own_instance",
    "min share": "min_throughput",
    "put off": "defer",
}
# What may stand all the same, and why. Each is a regular expression, taken out of a line before it is read.
k_exceptions = [
    (r"--movers\b", "an option of `bench shadow-textures`; scripts use it"),
    (r'"movers"', "the option's name in the table of options, and a key of its JSON"),
    (r'"pictures?"', "keys of JSON that scripts read"),
    (r"\bmedian_picture_ms\b", "a key of JSON that scripts read"),
    (r"\bmovers=", "a parameter of builtin:spheres; scripts use it"),
    (r"sentences with a subject and a verb", "the verb of grammar"),
    (r"</?picture>", "an element of HTML"),
    (r"AnisotropyBarnLamp", "the name of a model"),
    (r"\bfilm_transparent\b", "a property of Blender"),
    (r"[Tt]hin[ _]?[Ff]ilms?", "the optical term: a layer that light interferes in"),
]
# Files that must hold such words: they list them, or are data.
k_files = {
    "tools/check_words.py": "lists the words",
    "tests/tools/check_words_test.py": "tests this check",
    "CHANGELOG.md": "names what was renamed",
}
k_prose = check_text.k_sources | {".md", ".js", ".css", ".html", ".in", ".txt"}

k_token = re.compile(r"[A-Za-z]+")
k_part = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")


def faults_of(line: str):
    """Every retired word of a line, with what to say instead."""
    for pattern, _ in k_exceptions:
        line = re.sub(pattern, " ", line)
    for token in k_token.findall(line):
        for part in k_part.findall(token):
            word = part.lower()
            singular = word[:-1] if word.endswith("s") and word[:-1] in k_words else word
            if singular in k_words:
                yield word, k_words[singular]
            for stem, better in k_stems.items():
                if word.startswith(stem):
                    yield word, better
    plain = " ".join(part.lower() for part in k_part.findall(line.replace("'", "")))
    for phrase, better in k_phrases.items():
        if re.search(rf"\b{phrase}\b", plain):
            yield phrase, better


def is_read(path: pathlib.Path, name: str) -> bool:
    return (path.suffix in k_prose or path.name in check_text.k_source_names) and name not in k_files


def main() -> int:
    parser = argparse.ArgumentParser(description="finds retired words")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    parser.add_argument("--count", action="store_true", help="how many there are, by file and by word")
    arguments = parser.parse_args()
    read, by_file, by_word = 0, collections.Counter(), collections.Counter()
    for path in check_text.repository_files(arguments.root):
        name = path.relative_to(arguments.root).as_posix()
        if path.is_symlink() or not path.is_file() or not is_read(path, name):
            continue
        read += 1
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), 1):
            for word, better in faults_of(line):
                by_file[name] += 1
                by_word[word] += 1
                if not arguments.count:
                    print(f"{name}:{number}: retired word '{word}': say '{better}'")
    if arguments.count:
        for counter in (by_file, by_word):
            print("\n".join(f"{count:5} {key}" for key, count in counter.most_common()))
    if not by_file:
        print(f"words: {read} files, no fault")
    if read == 0:
        print(f"words: no file below {arguments.root}", file=sys.stderr)
    return 1 if by_file or read == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
