#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Input filter of Doxygen: shows it the comments of a public header that are written without its marks.

    doxygen_filter.py HEADER        prints the header as Doxygen shall read it

The headers of include/gnomon have three kinds of comments:

    `//` below `#pragma once`   describes the file
    `///` above a declaration   is read by Doxygen as it is
    `//` behind a declaration   describes what the line declares; it continues on lines that are indented more

Types, functions, enumerations and constants need a comment, else Doxygen warns. A data member whose name and type say
enough needs none, nor does a constructor or an assignment that copies or moves: they get an empty one. Comparison
operators are left out. Every line keeps its number, so that warnings name the right one.
"""
import pathlib
import re
import sys

# Code, then a comment with one mark of two slashes. A slash in quotes does not begin a comment.
k_trailing = re.compile(r'^(?P<indent>\s*)(?P<code>(?:[^/"]|"(?:[^"\\]|\\.)*"|/(?!/))*[^\s/])\s*'
                        r'//(?!/)\s*(?P<text>.*)$')
k_comment = re.compile(r"^(?P<indent>\s*)//(?!/)\s?(?P<text>.*)$")
k_scope = re.compile(r"[{}]\s*$|^\s*(?:public|private|protected|#|namespace\b)")   # lines that declare no member
k_declaration = re.compile(r"[,;}]$|^\s*\w+(?:\s*=\s*\w+)?$")   # the last enumerator has no comma
k_member = re.compile(r"^\s+(?!using |friend |return |struct |class |enum )[\w:]+(?:<.*>)? \w+[^()]*;$")
k_special = re.compile(r"^\s+(?:(\w+)\((?:const \1&|\1&&)\)|(\w+)& operator=\((?:const \2&|\2&&)\))"
                       r"(?: noexcept)?(?: = default)?;$")
k_of_struct = re.compile(r"^\s*} \w+;$")   # a variable, declared with its type
k_comparison = re.compile(r"^\s*friend bool operator==\(.*\) = default;$")


k_no_words = "&zwj;"   # a character that is not shown; Doxygen takes an empty comment for none


def file_description(lines: list[str]) -> int:
    """Turns the comment below `#pragma once` into the file's description; returns the number of the line after it."""
    if "#pragma once" not in lines:
        return 0
    number = lines.index("#pragma once")
    if number + 1 >= len(lines) or not k_comment.match(lines[number + 1]):
        return number + 1
    lines[number] = r"/// \file"
    number += 1
    while number < len(lines) and (comment := k_comment.match(lines[number])):
        lines[number] = f"/// {comment['text']}".rstrip()
        number += 1
    return number


def separated(code: str) -> list[str]:
    """A declaration of several variables as one declaration each: Doxygen gives a comment to the first alone."""
    type_name = re.match(r"\s*[\w:]+(?:<.*>)? ", code)
    if not type_name or not code.endswith(";"):
        return [code]
    names, depth = [""], 0
    for character in code[type_name.end():-1]:
        depth += (character in "({[<") - (character in ")}]>")
        if character == "," and depth == 0:
            names.append("")
        else:
            names[-1] += character
    return [f"{type_name[0].strip()} {name.strip()};" for name in names]


def commented(code: str, words: str) -> str:
    return " ".join(f"/** {words} */ {declaration.strip()}" for declaration in separated(code))


def filtered(source: str) -> str:
    lines = source.split("\n")
    number = file_description(lines)
    while number < len(lines):
        if k_comparison.match(lines[number]):
            lines[number] = ""
        if k_member.match(lines[number]) or k_special.match(lines[number]):
            if not lines[number - 1].lstrip().startswith("///"):
                lines[number] = commented(lines[number], k_no_words)
        elif k_of_struct.match(lines[number]):
            lines[number] += f" ///< {k_no_words}"
        match = k_trailing.match(lines[number])
        if not match or k_scope.search(match["code"]) or not k_declaration.search(match["code"]):
            number += 1
            continue
        indent = len(match["indent"])
        first, words = number, [match["text"]]
        number += 1
        while number < len(lines) and (more := k_comment.match(lines[number])) and len(more["indent"]) > indent:
            words.append(more["text"])
            lines[number] = ""
            number += 1
        lines[first] = commented(match["code"], " ".join(words))
    return "\n".join(lines)


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    sys.stdout.write(filtered(pathlib.Path(sys.argv[1]).read_text()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
