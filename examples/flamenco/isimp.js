// A job type for Flamenco 3: simplifies scans on the workers of a render farm.
//
// Copy this file to the folder `scripts` beside the manager of Flamenco and restart it. The workers need isimp, and the
// scans and the results at paths that are the same on all of them. docs/scale.md has an example.

const JOB_TYPE = {
  label: "isimp",
  description: "Turn dense scans into polygon models: a task for each scan, or one for a folder or for a scan in tiles",
  settings: [
    {
      key: "scans",
      type: "string",
      required: true,
      description: "Files, folders or patterns, with ; between them. A file is a task of its own, a folder is a batch",
    },
    { key: "output_folder", type: "string", subtype: "dir_path", required: true, description: "Where results go" },
    { key: "format", type: "string", required: true, default: "obj", choices: ["obj", "ply", "glb"] },
    { key: "tiles", type: "bool", default: false, description: "Each folder or file is one scan, done in tiles" },
    { key: "options", type: "string", default: "--detail 0.005", description: "As of isimp simplify, batch or tiles" },
    { key: "isimp", type: "string", default: "isimp", description: "The command on the workers" },
  ],
};

const KINDS = /\.(ply|obj|stl|off|glb|gltf)(\.gz|\.zst)?$/i;
const PATTERN = /[*?[]/;

function compileJob(job) {
  const settings = job.settings;
  const scans = settings.scans.split(";").map((text) => text.trim()).filter((text) => text !== "");
  if (scans.length === 0) throw new Error("isimp: the setting scans names no file and no folder");
  const options = words(settings.options);
  const taken = {};
  const batches = [];
  for (const scan of scans) {
    if (!settings.tiles && (!KINDS.test(scan) || PATTERN.test(scan))) {
      batches.push(scan);
      continue;
    }
    const result = join(settings.output_folder, named(scan, settings.format, taken));
    const verb = settings.tiles ? "tiles" : "simplify";
    add(job, verb + " " + base(scan), settings.isimp, [verb, scan, result].concat(options, "--quiet"));
  }
  // One task, since one process at a time works on the rows of an output folder.
  if (batches.length > 0) {
    const command = ["batch"].concat(batches, settings.output_folder, "--format", settings.format, options, "--quiet");
    add(job, "batch", settings.isimp, command);
  }
}

function add(job, name, exe, args) {
  const task = author.Task(name, "misc");
  task.addCommand(author.Command("exec", { exe: exe, args: args }));
  job.addTask(task);
}

// The words of a line; quotes keep what has spaces together.
function words(line) {
  const found = (line || "").match(/"[^"]*"|'[^']*'|[^\s"']+/g) || [];
  return found.map((word) => word.replace(/^(["'])(.*)\1$/, "$2"));
}

function base(path) {
  return path.replace(/[\\/]+$/, "").split(/[\\/]/).pop();
}

function join(folder, name) {
  return folder.replace(/[\\/]+$/, "") + "/" + name;
}

// The name of a scan's result; of two scans with one name the second gets a number.
function named(scan, format, taken) {
  const stem = base(scan).replace(KINDS, "");
  const times = (taken[stem.toLowerCase()] = (taken[stem.toLowerCase()] || 0) + 1);
  return stem + (times > 1 ? "-" + times : "") + "." + format;
}
