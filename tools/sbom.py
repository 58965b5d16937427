#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lists what a build of Gnomon links, as an SPDX 2.3 document in JSON (a software bill of materials).

    sbom.py BUILD VERSION OUT.spdx.json

Three kinds of Debian packages are listed: those whose shared libraries the program or the library needs (as the dynamic
linker finds them), those whose static libraries are linked, and those whose headers or scripts are compiled in (as Ninja
recorded them). The document is the same for the same packages: its time is SOURCE_DATE_EPOCH, else 1970, and its name
is a hash of its contents.
"""
import datetime
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

EMBEDDED = ("/usr/share/javascript/chart.js/chart.min.js",)   # compiled in as text


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def owners():
    """The package of each installed file."""
    table = {}
    for listed in Path("/var/lib/dpkg/info").glob("*.list"):
        package = listed.stem.split(":")[0]
        for line in listed.read_text(encoding="utf-8", errors="replace").splitlines():
            table[line] = package
    return table


def owner_of(path, table):
    """Debian's packages may say /lib for what lies in /usr/lib, and for a target of links."""
    real = os.path.realpath(path)
    for name in (path, real, real.removeprefix("/usr"), path.removeprefix("/usr"), "/usr" + path):
        if name in table:
            return table[name]
    return None


def shared(binaries):
    """Paths of the libraries that the binaries need themselves, without what those need in turn."""
    found = set()
    for binary in binaries:
        needed = re.findall(r"\(NEEDED\).*\[(.*)\]", output_of("readelf", "-d", str(binary)))
        paths = dict(re.findall(r"^\s*(\S+) => (\S+)", output_of("ldd", str(binary)), re.M))
        found |= {paths[name] for name in needed if name in paths}
    return found


def static(build):
    """Paths of archives of other packages on the command lines of the linker."""
    words = output_of("ninja", "-C", str(build), "-t", "commands", "gnomon").split()
    return {word for word in words if word.startswith("/") and word.endswith(".a")}


def compiled_in(build, source):
    """Paths of files outside of the sources that were read by the compiler."""
    lines = output_of("ninja", "-C", str(build), "-t", "deps").splitlines()
    paths = {line.strip() for line in lines if line.startswith("    /")}
    inside = (str(source) + "/", str(build) + "/")
    return {os.path.normpath(path) for path in paths if not path.startswith(inside)} | set(EMBEDDED)


def package_entry(name, version, architecture, comment):
    return {
        "SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name),
        "name": name,
        "versionInfo": version,
        "supplier": "Organization: Debian",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": "NOASSERTION",
        "licenseComments": f"/usr/share/doc/{name}/copyright",
        "copyrightText": "NOASSERTION",
        "comment": comment,
        "externalRefs": [{
            "referenceCategory": "PACKAGE-MANAGER",
            "referenceType": "purl",
            "referenceLocator": f"pkg:deb/debian/{name}@{version.replace('+', '%2B').replace(':', '%3A')}"
                                f"?arch={architecture}&distro=debian-12",
        }],
    }


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    build, version, out = Path(sys.argv[1]).resolve(), sys.argv[2], Path(sys.argv[3])
    source = Path(__file__).resolve().parents[1]
    table = owners()
    binaries = [build / "gnomon", *build.glob("libgnomon.so.*.*.*")]
    kinds = [("DYNAMIC_LINK", "shared library", shared(binaries)), ("STATIC_LINK", "static library", static(build)),
             ("STATIC_LINK", "headers or scripts that are compiled in", compiled_in(build, source))]

    # A package may have a shared library and headers; each kind has a relationship of its own.
    found = {}
    for kind, comment, paths in kinds:
        for path in sorted(paths):
            name = owner_of(path, table)
            if name is None:
                sys.exit(f"sbom: no package has {path}")
            found.setdefault(name, {})[comment] = kind
    status = output_of("dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}\n", *sorted(found))
    installed = dict(line.split("\t", 1) for line in status.splitlines())

    packages = [{
        "SPDXID": "SPDXRef-gnomon",
        "name": "gnomon",
        "versionInfo": version,
        "supplier": "NOASSERTION",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "Apache-2.0",
        "licenseDeclared": "Apache-2.0",
        "copyrightText": "The authors of Gnomon",
    }]
    relationships = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                      "relatedSpdxElement": "SPDXRef-gnomon"}]
    for name in sorted(found):
        entry = package_entry(name, *installed[name].split("\t"), ", ".join(sorted(found[name])))
        packages.append(entry)
        for kind in sorted(set(found[name].values())):
            relationships.append({"spdxElementId": "SPDXRef-gnomon", "relationshipType": kind,
                                  "relatedSpdxElement": entry["SPDXID"]})
    time = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), datetime.timezone.utc)
    digest = hashlib.sha256(json.dumps([packages, relationships], sort_keys=True).encode()).hexdigest()
    document = {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"gnomon-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/gnomon-{version}-{digest[:32]}",
        "creationInfo": {"created": time.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: gnomon-sbom"]},
        "packages": packages,
        "relationships": relationships,
    }
    out.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    print(f"{out}: {len(packages) - 1} packages")


if __name__ == "__main__":
    main()
