export interface Packed {
  readonly steps: string;
  readonly texts: readonly string[];
}

export declare function keyOf(english: string): number;
export declare function pack(catalogue: Readonly<Record<string, string>>): Packed;
export declare function unpack(packed: Packed): (english: string) => string | undefined;
