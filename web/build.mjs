// Bundles src/ into one script and one style sheet that need nothing else; a digest of the sources stands beside them.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "..", "src", "cutwise", "app", "page", "static");

const common = { bundle: true, minify: true, target: "es2022", legalComments: "none", absWorkingDir: here, logLevel: "warning" };
await build({ ...common, entryPoints: ["src/main.ts"], format: "iife", outfile: join(out, "view.js") });
await build({ ...common, entryPoints: ["src/style.css"], outfile: join(out, "view.css") });

const licence = (name) => {
  const { version } = JSON.parse(readFileSync(join(here, "node_modules", name, "package.json"), "utf8"));
  return `${name} ${version}\n\n${readFileSync(join(here, "node_modules", name, "LICENSE"), "utf8").trim()}\n`;
};
writeFileSync(join(out, "view.LICENSES.txt"), ["three", "uplot"].map(licence).join("\n" + "-".repeat(70) + "\n\n"));

// every file that the bundle is made of, by name and content with line ends as git keeps them
const sources = ["build.mjs", "package.json", "package-lock.json", "tsconfig.json", ...readdirSync(join(here, "src")).map((name) => `src/${name}`)].sort();
const digest = createHash("sha256");
for (const name of sources) digest.update(`${name}\n`).update(readFileSync(join(here, name), "utf8").replaceAll("\r\n", "\n"));
writeFileSync(join(out, "view.sources.sha256"), `${digest.digest("hex")}\n`);
