// OpenLayers without what no page uses: styles as expressions (the pages style by functions), and tiles of other projections
// (the chart's are in the map's own). Imports alone bring these in, and they would be a tenth of a page.

const LEFT_OUT = {
  "ol/render/canvas/style.js": `export function flatStyleLikeToStyleFunction() { throw new Error("Styles as expressions are not in this bundle: give a function (web/scripts/openlayers.mjs)."); }`,
  "ol/reproj/Tile.js": `export default class ReprojTile { constructor() { throw new Error("Other projections are not in this bundle (web/scripts/openlayers.mjs)."); } }`,
};

export const openLayersPlugin = {
  name: "openlayers",
  setup({ onLoad }) {
    onLoad({ filter: /[\\/]ol[\\/](render[\\/]canvas[\\/]style|reproj[\\/]Tile)\.js$/ }, ({ path }) => {
      const contents = Object.entries(LEFT_OUT).find(([end]) => path.replaceAll("\\", "/").endsWith(end))?.[1];
      return contents && { contents, loader: "js" };
    });
  },
};
