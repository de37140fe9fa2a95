// OpenLayers without what no page uses: styles as expressions (the pages style by functions), projections other than the map's
// own and tiles of them, a list of features at a pixel by layer (the pages ask the map), and words of attribution. Imports alone
// bring these in, and they would be a tenth of a page.

const LEFT_OUT = {
  "ol/render/canvas/style.js": `export function flatStyleLikeToStyleFunction() { throw new Error("Styles as expressions are not in this bundle: give a function (web/scripts/openlayers.mjs)."); }`,
  "ol/reproj/Tile.js": `export default class ReprojTile { constructor() { throw new Error("Other projections are not in this bundle (web/scripts/openlayers.mjs)."); } }`,
  "ol/render/canvas/hitdetect.js": `export const HIT_DETECT_RESOLUTION = 0.5;
export function createHitDetectionImageData() { throw new Error("layer.getFeatures() is not in this bundle: ask the map by forEachFeatureAtPixel (web/scripts/openlayers.mjs)."); }
export const hitDetect = createHitDetectionImageData;`,
  "ol/proj/utm.js": `export function makeProjection() { return null; }
export function makeTransforms() { return null; }`,
  "ol/control/Attribution.js": `export default class Attribution { constructor() { throw new Error("Attributions are not in this bundle (web/scripts/openlayers.mjs)."); } }`,
};

export const openLayersPlugin = {
  name: "openlayers",
  setup({ onLoad }) {
    const paths = Object.keys(LEFT_OUT).map((path) => path.replaceAll("/", "[\\\\/]").replace(".js", "\\.js"));
    onLoad({ filter: new RegExp(`[\\\\/](${paths.join("|")})$`) }, ({ path }) => {
      const contents = Object.entries(LEFT_OUT).find(([end]) => path.replaceAll("\\", "/").endsWith(end))?.[1];
      return contents && { contents, loader: "js" };
    });
  },
};
