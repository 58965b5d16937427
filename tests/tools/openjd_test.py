#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the job template of examples/openjd against the specification of Open Job Description, and runs it.

The rules are those of "Template Schemas [Version: 2023-09]" with the extension TASK_CHUNKING, as far as the template uses
them; a member or a kind that is not listed here is refused. Numbers in brackets are sections of the specification.

    openjd_test.py PROGRAM
"""
import copy
import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TEMPLATE = Path(__file__).resolve().parents[2] / "examples/openjd/template.json"
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}")                              # [7.1]
REFERENCE = re.compile(r"{{\s*([A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)\s*}}")   # [7.3]
CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")
CAPABILITY = re.compile(r"attr\.worker\.[a-z_]+(\.[a-z_]+)*")                        # [3.3.2.1]
INTEGERS = re.compile(r"\s*-?\d+\s*(-\s*-?\d+\s*(:-?[1-9]\d*)?)?")                   # one element of [3.4.1.1.1]


class Fault(Exception):
    """The template breaks a rule."""


def need(condition, what):
    if not condition:
        raise Fault(what)


def members(value, required, optional, where):
    need(isinstance(value, dict), f"{where}: expected an object")
    need(required <= value.keys(), f"{where}: {sorted(required - value.keys())} missing")
    need(value.keys() <= required | optional, f"{where}: {sorted(value.keys() - required - optional)} unknown")


def text(value, least, most, where):
    need(isinstance(value, str) and least <= len(value) <= most, f"{where}: expected {least} to {most} characters")
    need(not CONTROL.search(value), f"{where}: control character")


def format_string(value, known, where):
    """Returns the references of a format string; every double brace belongs to one that is known."""
    need(isinstance(value, str), f"{where}: expected a string")
    names = REFERENCE.findall(value)
    need("{{" not in REFERENCE.sub("", value) and "}}" not in REFERENCE.sub("", value), f"{where}: unpaired braces")
    for name in names:
        need(name in known, f"{where}: {name} is not known here")
    return names


def whole_number(value, least, where):
    need(isinstance(value, int) and not isinstance(value, bool) and value >= least, f"{where}: expected at least {least}")


def check_parameters(definitions):
    """[2] Returns the references of the job's parameters: everywhere, and in scripts alone."""
    need(isinstance(definitions, list) and 1 <= len(definitions) <= 50, "1 to 50 parameters")
    everywhere, scripts = set(), set()
    more = {"PATH": {"objectType", "dataFlow"}, "INT": {"minValue", "maxValue"}, "STRING": {"minLength", "maxLength"}}
    for definition in definitions:
        where = f"parameter {definition.get('name')}"
        need(definition.get("type") in more, f"{where}: type")
        members(definition, {"name", "type"}, {"description", "default"} | more[definition["type"]], where)
        name = definition["name"]
        need(IDENTIFIER.fullmatch(name) and "Param." + name not in scripts, f"{where}: name")
        text(definition.get("description", "x"), 1, 2048, where)
        if definition["type"] == "INT":
            for member in ("default", "minValue", "maxValue"):
                whole_number(definition.get(member, 0), -(2**31), f"{where}: {member}")
            need(definition.get("default", definition.get("minValue", 0)) >= definition.get("minValue", -(2**31)), where)
        else:
            text(definition.get("default", ""), 0, 1024, where)
        need(definition.get("objectType", "FILE") in ("FILE", "DIRECTORY"), f"{where}: objectType")
        need(definition.get("dataFlow", "NONE") in ("NONE", "IN", "OUT", "INOUT"), f"{where}: dataFlow")
        scripts |= {"Param." + name, "RawParam." + name}
        # [7.3.1] The mapped value of a path is available in scripts only.
        everywhere |= {"RawParam." + name} | (set() if definition["type"] == "PATH" else {"Param." + name})
    return everywhere, scripts


def check_space(space, known, extensions):
    """[3.4] Returns the references of the task's parameters."""
    members(space, {"taskParameterDefinitions"}, {"combination"}, "parameterSpace")
    definitions = space["taskParameterDefinitions"]
    need(isinstance(definitions, list) and 1 <= len(definitions) <= 16, "1 to 16 task parameters")
    names = set()
    for definition in definitions:
        where = f"task parameter {definition.get('name')}"
        chunked = definition.get("type") == "CHUNK[INT]"
        need(chunked or definition.get("type") == "INT", f"{where}: type")
        members(definition, {"name", "type", "range"} | ({"chunks"} if chunked else set()), set(), where)
        need(IDENTIFIER.fullmatch(definition["name"]), f"{where}: name")
        format_string(definition["range"], known, where)
        for element in REFERENCE.sub("1", definition["range"]).split(","):
            need(INTEGERS.fullmatch(element), f"{where}: range")
        if chunked:   # [3.4.1.5]
            need("TASK_CHUNKING" in extensions, f"{where}: needs the extension TASK_CHUNKING")
            chunks = definition["chunks"]
            members(chunks, {"defaultTaskCount", "rangeConstraint"}, {"targetRuntimeSeconds"}, where)
            need(chunks["rangeConstraint"] in ("CONTIGUOUS", "NONCONTIGUOUS"), f"{where}: rangeConstraint")
            for member, least in (("defaultTaskCount", 1), ("targetRuntimeSeconds", 0)):
                value = chunks.get(member, 1)
                if isinstance(value, str):
                    format_string(value, known, f"{where}: {member}")
                    value = int(REFERENCE.sub("1", value))
                whole_number(value, least, f"{where}: {member}")
        names |= {"Task.Param." + definition["name"], "Task.RawParam." + definition["name"]}
    need(sum(d["type"] == "CHUNK[INT]" for d in definitions) <= 1, "more than one chunked parameter")
    return names


def check_action(action, known, where):
    """[5]"""
    members(action, {"command"}, {"args", "timeout", "cancelation"}, where)
    text(action["command"], 1, 10**6, where)
    format_string(action["command"], known, where)
    need(isinstance(action.get("args", []), list), f"{where}: args")
    for argument in action.get("args", []):
        text(argument, 0, 10**6, where)
        format_string(argument, known, where)
    if "cancelation" in action:
        cancelation = action["cancelation"]
        notify = cancelation.get("mode") == "NOTIFY_THEN_TERMINATE"
        need(notify or cancelation.get("mode") == "TERMINATE", f"{where}: mode")
        members(cancelation, {"mode"}, {"notifyPeriodInSeconds"} if notify else set(), where)
        whole_number(cancelation.get("notifyPeriodInSeconds", 1), 1, where)
        need(cancelation.get("notifyPeriodInSeconds", 1) <= 600, f"{where}: notifyPeriodInSeconds")


def check_step(step, before, everywhere, scripts, extensions):
    """[3]"""
    where = f"step {step.get('name')}"
    members(step, {"name", "script"}, {"description", "dependencies", "hostRequirements", "parameterSpace"}, where)
    text(step["name"], 1, 64, where)
    need(step["name"] not in before, f"{where}: its name is taken")
    dependencies = step.get("dependencies", [{"dependsOn": None}])
    need(isinstance(dependencies, list) and dependencies, f"{where}: dependencies")
    for dependency in step.get("dependencies", []):
        members(dependency, {"dependsOn"}, set(), where)
        need(dependency["dependsOn"] in before, f"{where}: depends on {dependency['dependsOn']}")
    if "hostRequirements" in step:   # [3.3]
        members(step["hostRequirements"], {"attributes"}, set(), where)
        need(1 <= len(step["hostRequirements"]["attributes"]) <= 50, f"{where}: attributes")
        for attribute in step["hostRequirements"]["attributes"]:
            members(attribute, {"name", "anyOf"}, set(), where)
            need(CAPABILITY.fullmatch(attribute["name"]) and len(attribute["name"]) <= 100, f"{where}: attribute")
            need(1 <= len(attribute["anyOf"]) <= 50, f"{where}: anyOf")
            for value in attribute["anyOf"]:
                need(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_-]{0,99}", value), f"{where}: {value}")
    known = set(scripts)
    if "parameterSpace" in step:
        known |= check_space(step["parameterSpace"], everywhere, extensions)
    members(step["script"], {"actions"}, set(), where)
    members(step["script"]["actions"], {"onRun"}, set(), where)
    check_action(step["script"]["actions"]["onRun"], known, where)


def check(template):
    """[1.1] @raises Fault"""
    members(template, {"specificationVersion", "name", "steps"},
            {"$schema", "extensions", "description", "parameterDefinitions"}, "template")
    need(template["specificationVersion"] == "jobtemplate-2023-09", "specificationVersion")
    extensions = template.get("extensions", ["TASK_CHUNKING"])
    need(isinstance(extensions, list) and extensions and set(extensions) <= {"TASK_CHUNKING"}, "extensions")
    text(template["name"], 1, 128, "name")
    text(template.get("description", "x"), 1, 2048, "description")
    everywhere, scripts = check_parameters(template.get("parameterDefinitions", []))
    format_string(template["name"], everywhere, "name")
    need(isinstance(template["steps"], list) and template["steps"], "steps")
    names = []
    for step in template["steps"]:
        check_step(step, names, everywhere, scripts, template.get("extensions", []))
        names.append(step["name"])


def resolve(value, values):
    return REFERENCE.sub(lambda match: str(values[match.group(1)]), value)


def tasks_of(step, values):
    """The values of each task of a step: a contiguous chunk is "first-last", also of one frame [3.4.1.5]."""
    if "parameterSpace" not in step:
        return [values]
    definition, = step["parameterSpace"]["taskParameterDefinitions"]
    first, last = map(int, resolve(definition["range"], values).split("-"))
    count = int(resolve(str(definition["chunks"]["defaultTaskCount"]), values))
    name = "Task.Param." + definition["name"]
    return [{**values, name: f"{at}-{min(at + count - 1, last)}"} for at in range(first, last + 1, count)]


class Template(unittest.TestCase):
    program = None

    def setUp(self):
        self.template = json.loads(TEMPLATE.read_text(encoding="utf-8"))

    def test_follows_the_specification(self):
        check(self.template)

    def test_the_check_finds_faults(self):
        def render(t):
            return t["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]

        def run(t):
            return t["steps"][1]["script"]["actions"]["onRun"]
        faults = [
            lambda t: t.pop("extensions"),
            lambda t: t.update(specificationVersion="2023-09"),
            lambda t: t.update(author="me"),
            lambda t: t.update(name="{{Param.Scene}}"),
            lambda t: t["parameterDefinitions"][0].update(type="FILE"),
            lambda t: t["parameterDefinitions"][0].update(dataFlow="READ"),
            lambda t: t["parameterDefinitions"][2].update(default=0),
            lambda t: t["parameterDefinitions"].append(t["parameterDefinitions"][0]),
            lambda t: render(t).update(type="CHUNK"),
            lambda t: render(t).update(range="{{Param.FirstFrame}}-"),
            lambda t: render(t).update(range="{{Param.Scene}}"),
            lambda t: render(t).pop("chunks"),
            lambda t: render(t)["chunks"].update(defaultTaskCount=0),
            lambda t: render(t)["chunks"].update(rangeConstraint="ANY"),
            lambda t: run(t).update(command=""),
            lambda t: run(t)["args"].append("{{Task.Param.Frames}}"),
            lambda t: run(t)["args"].append("{{Param.Out"),
            lambda t: run(t)["cancelation"].update(notifyPeriodInSeconds=601),
            lambda t: t["steps"][1].update(dependencies=[{"dependsOn": "Encode"}]),
            lambda t: t["steps"][1].update(name="Render"),
        ]
        for number, fault in enumerate(faults):
            template = copy.deepcopy(self.template)
            fault(template)
            with self.assertRaises(Fault, msg=f"fault {number}"):
                check(template)

    def test_makes_the_bytes_of_one_run(self):
        if not shutil.which("ffmpeg"):
            self.skipTest("no ffmpeg")
        with tempfile.TemporaryDirectory() as folder:
            given = {"Scene": "builtin:cornell", "Out": folder + "/video.mp4", "LastFrame": 7, "ChunkLength": 3,
                     "Size": "65x49", "Program": self.program}
            values = {"Param." + d["name"]: given.get(d["name"], d.get("default"))
                      for d in self.template["parameterDefinitions"]}
            for step in self.template["steps"]:
                action = step["script"]["actions"]["onRun"]
                for task in tasks_of(step, values):
                    words = [action["command"], *action["args"]]
                    subprocess.run([resolve(word, task) for word in words], check=True, stdout=subprocess.DEVNULL)
            whole = folder + "/whole.mp4"
            subprocess.run([self.program, "render", "builtin:cornell", "-o", whole, "--frames", "1-7", "--size", "65x49",
                            "--quiet"], check=True)
            self.assertEqual(Path(whole).read_bytes(), Path(folder, "video.mp4").read_bytes())


if __name__ == "__main__":
    Template.program = sys.argv.pop()
    unittest.main()
