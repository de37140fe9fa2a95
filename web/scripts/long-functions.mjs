// Counts the lines of each function of the scripts, by TypeScript's own parser: `node scripts/long-functions.mjs [limit]`
// lists those that are longer than a screenful, the longest first, and fails if there are any. A function's lines are its
// own from its first word to its last brace, with those of the functions inside it.

import { dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { SyntaxKind } from "typescript/unstable/ast";
import { API } from "typescript/unstable/sync";

const project = dirname(dirname(fileURLToPath(import.meta.url)));
const limit = Number(process.argv[2] ?? 60);
const FUNCTIONS = new Set([
  SyntaxKind.FunctionDeclaration,
  SyntaxKind.FunctionExpression,
  SyntaxKind.ArrowFunction,
  SyntaxKind.MethodDeclaration,
  SyntaxKind.Constructor,
  SyntaxKind.GetAccessor,
  SyntaxKind.SetAccessor,
]);

const api = new API({ cwd: project });
const [long, configs] = [[], ["tsconfig.json", "tsconfig.worker.json"].map((name) => `${project}/${name}`)];
const seen = new Set();
let all = 0;
for (const config of configs) {
  const { program, rootFiles } = api.updateSnapshot({ openProject: config }).getProject(config);
  for (const path of rootFiles) {
    if (seen.has(path)) continue;
    seen.add(path);
    const file = program.getSourceFile(path);
    const line = (at) => file.text.slice(0, at).split("\n").length;
    const visit = (node) => {
      if (FUNCTIONS.has(node.kind)) {
        all += 1;
        const [from, to] = [line(node.getStart(file)), line(node.end)];
        const name = node.name?.text ?? node.parent?.name?.text ?? "(no name)";
        if (to - from + 1 > limit) long.push({ lines: to - from + 1, where: `${path.slice(project.length + 1)}:${from}`, name });
      }
      node.forEachChild(visit);
    };
    visit(file);
  }
}
api.close();
for (const { lines, where, name } of long.sort((one, other) => other.lines - one.lines)) console.log(`${String(lines).padStart(4)} ${where} ${name}`);
console.log(`${long.length} of ${all} functions are longer than ${limit} lines`);
process.exitCode = long.length ? 1 : 0;
