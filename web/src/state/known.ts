// Which systems are vessels that somebody may choose: pure.

/** Consoles, and the server among them, have these addresses in IMC: the uppermost three bits are 010. */
const [CONSOLE_BITS, CONSOLES] = [0xe000, 0x4000];

/** Those with a name, and others of which something is recorded unless they are consoles. */
export function knownVessels(names: Readonly<Record<string, string>>, recorded: readonly { readonly system: number }[]): number[] {
  const others = recorded.map(({ system }) => system).filter((system) => (system & CONSOLE_BITS) !== CONSOLES);
  return [...new Set([...Object.keys(names).map(Number), ...others])];
}
