// A demo of the server for who looks at it: simulated Otters that sail, until the work before it is done.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";

/** Starts `program demo` with `options`, does `work` once otter-1 sails, and ends the demo however that goes. */
export async function withDemo(program, options, work) {
  const demo = spawn(program, ["demo", ...options, "--listen", "127.0.0.1:0"], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    let [url, password] = ["", ""];
    for await (const line of createInterface({ input: demo.stdout })) {
      const told = /^server\s+(\S+)\s+log in as admin with the password (\S+)/.exec(line);
      if (told) [, url, password] = told;
      if (/otter-1\s+sails/.test(line)) break;
    }
    await work({ url, password });
  } finally {
    demo.kill("SIGTERM");
    if (demo.exitCode === null) await once(demo, "exit");
  }
}
