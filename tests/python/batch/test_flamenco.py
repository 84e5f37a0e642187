"""The job type for Flamenco makes the tasks of its settings: run by node, with a small manager."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from isimp_engine.cli.command import parser

JOB_TYPE = Path(__file__).parents[3] / "examples" / "flamenco" / "isimp.js"
MANAGER = """
const vm = require("vm"), fs = require("fs");
const author = {
  Task: (name, type) => ({ name, type, commands: [], addCommand(c) { this.commands.push(c); } }),
  Command: (name, parameters) => ({ name, parameters }),
};
const context = vm.createContext({ author });
vm.runInContext(fs.readFileSync(process.argv[1], "utf8") + "\\nthis.type = JOB_TYPE;", context);
const given = JSON.parse(process.argv[2]), settings = {}, tasks = [];
for (const s of context.type.settings) settings[s.key] = s.key in given ? given[s.key] : s.default;
try {
  context.compileJob({ settings, addTask: (task) => tasks.push(task) });
  console.log(JSON.stringify({ tasks, type: context.type }));
} catch (error) { console.log(JSON.stringify({ error: error.message })); }
"""


def compiled(**settings):
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    command = [node, "-e", MANAGER, str(JOB_TYPE), json.dumps(settings)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def commands(**settings):
    tasks = compiled(output_folder="/out/", **settings)["tasks"]
    assert {(c["name"], t["type"], len(t["commands"])) for t in tasks for c in t["commands"]} == {("exec", "misc", 1)}
    return [task["commands"][0]["parameters"] for task in tasks]


def test_a_file_is_a_task_and_names_are_taken_once():
    found = commands(scans="/in/a.ply; /in/b c.obj.gz ;/other/A.PLY", options="--proxies 500 --recipe 'my r.json'")
    options = ["--proxies", "500", "--recipe", "my r.json", "--quiet"]
    assert [each["args"] for each in found] == [
        ["simplify", "/in/a.ply", "/out/a.obj", *options],
        ["simplify", "/in/b c.obj.gz", "/out/b c.obj", *options],
        ["simplify", "/other/A.PLY", "/out/A-2.obj", *options],
    ]
    assert {each["exe"] for each in found} == {"isimp"}


def test_folders_are_one_batch_and_tiles_are_one_scan_each():
    batch = commands(scans="/in;/more/*.ply;/x/site", format="ply", isimp="/opt/isimp")
    words = ["batch", "/in", "/more/*.ply", "/x/site", "/out/", "--format", "ply", "--detail", "0.005", "--quiet"]
    assert batch == [{"exe": "/opt/isimp", "args": words}]
    tiles = commands(scans="/city/", tiles=True, format="ply", options="--proxies 9")
    assert [each["args"] for each in tiles] == [["tiles", "/city/", "/out/city.ply", "--proxies", "9", "--quiet"]]


def test_nothing_to_do_is_refused():
    assert (
        compiled(scans=" ; ", output_folder="/out")["error"] == "isimp: the setting scans names no file and no folder"
    )


def test_the_command_accepts_the_arguments_of_the_tasks():
    for settings in ({"scans": "/in/a.ply;/in"}, {"scans": "/in", "tiles": True}):
        for each in commands(**settings):
            arguments = parser().parse_args(each["args"])
            assert arguments.quiet
            assert arguments.detail == 0.005
