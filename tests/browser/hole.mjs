// A way to a server that swallows: connections stay open, and nothing that is sent by them arrives, in either direction.

import { connect, createServer } from "node:net";

/** A way to `target`, an address of a server, from a port or any; `swallow(true)` makes it swallow, and what was open then stays dead for good. */
export async function wayTo(target, from = 0) {
  const { protocol, hostname, port } = new URL(target);
  const open = new Set();
  let swallows = false;
  const server = createServer((near) => {
    const one = { dead: swallows, ends: [near] };
    open.add(one);
    const far = swallows ? undefined : connect(Number(port), hostname);
    if (far) one.ends.push(far);
    // What is swallowed is taken all the same: the sender sees a line that works.
    near.on("data", (bytes) => one.dead || far?.write(bytes));
    far?.on("data", (bytes) => one.dead || near.write(bytes));
    const end = () => {
      // The good-bye of a dead line arrives nowhere.
      if (!one.dead) for (const one_end of one.ends) one_end.destroy();
    };
    for (const stream of one.ends) {
      stream.on("error", () => undefined);
      stream.on("close", end);
    }
    near.on("close", () => open.delete(one));
  });
  await new Promise((done) => server.listen(from, "127.0.0.1", done));
  return {
    url: `${protocol}//127.0.0.1:${server.address().port}`,
    swallow(is) {
      swallows = is;
      if (is) for (const one of open) one.dead = true;
    },
    /** Connections of the browser that are open and dead. */
    dead: () => [...open].filter((one) => one.dead).length,
    close() {
      server.close();
      for (const { ends } of open) for (const end of ends) end.destroy();
    },
  };
}
