/** What scripts say of `words/nb.json`, packed by `build.mjs`. */
declare module "lutra:nb" {
  const words: import("./packed.mjs").Packed;
  export default words;
}
