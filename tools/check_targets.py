#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No two targets link each other, directly or through others.

    check_targets.py LINK_GRAPH

LINK_GRAPH is what CMake wrote while configuring (build/*/link_graph.txt): a line for each target, "NAME: what it links".
Static libraries that link each other build all the same, so nothing else would tell. Prints each cycle on a line; exit
code 1 if there is any.
"""
import pathlib
import re
import sys

k_name = re.compile(r"[\w+-]+")


def read_graph(text: str) -> dict[str, set[str]]:
    """Links among the targets of the file alone; generator expressions such as $<LINK_ONLY:a> count as a."""
    lines = [line.partition(":") for line in text.splitlines() if line]
    names = {name for name, _, _ in lines}
    graph: dict[str, set[str]] = {name: set() for name in names}
    for name, _, links in lines:
        graph[name] |= set(k_name.findall(links)) & names
    return graph


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """One cycle for each link that closes one, found depth first."""
    found, done = [], set()

    def visit(target: str, path: list[str]) -> None:
        if target in path:
            found.append(path[path.index(target):] + [target])
            return
        if target in done:
            return
        for link in sorted(graph[target]):
            visit(link, path + [target])
        done.add(target)

    for target in sorted(graph):
        visit(target, [])
    return found


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    graph = read_graph(pathlib.Path(sys.argv[1]).read_text())
    found = cycles(graph)
    for cycle in found:
        print(f"targets: {' links '.join(cycle)}")
    links = sum(len(links) for links in graph.values())
    if links == 0:
        print("targets: no link in the graph", file=sys.stderr)
    if not found:
        print(f"targets: {len(graph)} with {links} links among them, no cycle")
    return 1 if found or links == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
