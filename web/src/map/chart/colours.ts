// Colours of the chart's canvas, after S-52 (IHO Presentation Library) in sRGB. They are made for a chart beside a
// bridge window, not for text: panels have their own.

export interface ChartColours {
  readonly drying: string;
  readonly veryShallow: string;
  readonly shallow: string;
  readonly safe: string;
  readonly deep: string;
  readonly land: string;
  readonly coast: string;
  readonly safety: string;
  readonly contour: string;
  readonly sounding: string;
  readonly soundingShallow: string;
  readonly noData: string;
  readonly noDataLine: string;
  readonly danger: string;
  readonly caution: string;
  readonly cautionFaint: string;
  readonly area: string;
  readonly outline: string;
  readonly text: string;
  readonly halo: string;
  readonly overscale: string;
  /** Colours of aids, by word. */
  readonly aids: Readonly<Record<string, string>>;
}

const DAY: ChartColours = {
  drying: "#83B295",
  veryShallow: "#73B6EF",
  shallow: "#98C5F2",
  safe: "#BAD5E1",
  deep: "#D4EAEE",
  land: "#C9B97A",
  coast: "#525A5C",
  safety: "#525A5C",
  contour: "#7D898C",
  sounding: "#5C686B",
  soundingShallow: "#070707",
  noData: "#A3B4B7",
  noDataLine: "#7D898C",
  danger: "#C545C3",
  caution: "#C545C3",
  cautionFaint: "#D3A6E9",
  area: "#7D898C",
  outline: "#070707",
  text: "#070707",
  halo: "#F4F8F9",
  overscale: "rgba(82, 90, 92, 0.55)",
  aids: { white: "#F4F8F9", black: "#070707", red: "#F15469", green: "#3FA56F", blue: "#3A78F0", yellow: "#F4DA48", grey: "#7D898C", brown: "#8F6B3A", amber: "#EB7D36", violet: "#A24FB5", orange: "#EB7D36", magenta: "#C545C3", pink: "#E59AB8" },
};

/** A screen that reflects the sun: depth areas far apart, every line and number black or nearly so. */
const SUN: ChartColours = {
  ...DAY,
  drying: "#6FA884",
  veryShallow: "#4FA3EE",
  shallow: "#8CC4FA",
  safe: "#CDE6F3",
  deep: "#F4FBFD",
  land: "#D9C067",
  coast: "#000000",
  safety: "#000000",
  contour: "#3A4446",
  sounding: "#1C2021",
  soundingShallow: "#000000",
  noDataLine: "#3A4446",
  danger: "#8A007F",
  caution: "#8A007F",
  cautionFaint: "#A74BC4",
  area: "#3A4446",
  outline: "#000000",
  text: "#000000",
  halo: "#FFFFFF",
  overscale: "rgba(0, 0, 0, 0.6)",
};

const DUSK: ChartColours = {
  drying: "#15251F",
  veryShallow: "#16232F",
  shallow: "#151B21",
  safe: "#0C0E0F",
  deep: "#070707",
  land: "#2C291B",
  coast: "#5A6466",
  safety: "#5A6466",
  contour: "#363C3D",
  sounding: "#5A6466",
  soundingShallow: "#9BA6A8",
  noData: "#1C2021",
  noDataLine: "#363C3D",
  danger: "#9A5FA0",
  caution: "#7A4C86",
  cautionFaint: "#4A3A51",
  area: "#474E4F",
  outline: "#8E999B",
  text: "#8E999B",
  halo: "#070707",
  overscale: "rgba(90, 100, 102, 0.6)",
  aids: { white: "#8E999B", black: "#000000", red: "#8A2F3A", green: "#276845", blue: "#1D3E7C", yellow: "#857622", grey: "#474E4F", brown: "#4E3B20", amber: "#8A4A20", violet: "#5A2C66", orange: "#8A4A20", magenta: "#7A2B79", pink: "#7E5566" },
};

const NIGHT: ChartColours = {
  drying: "#080B09",
  veryShallow: "#0A1522",
  shallow: "#060C14",
  safe: "#070707",
  deep: "#030303",
  land: "#14100C",
  coast: "#3A4142",
  safety: "#3A4142",
  contour: "#232829",
  sounding: "#394041",
  soundingShallow: "#5E6769",
  noData: "#0B0B0B",
  noDataLine: "#232829",
  danger: "#6B3A70",
  caution: "#512A54",
  cautionFaint: "#341234",
  area: "#2B3030",
  outline: "#596264",
  text: "#596264",
  halo: "#000000",
  overscale: "rgba(58, 65, 66, 0.7)",
  aids: { white: "#596264", black: "#000000", red: "#5E1A22", green: "#1A4730", blue: "#142B58", yellow: "#544A14", grey: "#2B3030", brown: "#332613", amber: "#552C12", violet: "#3A1A42", orange: "#552C12", magenta: "#4E1A4D", pink: "#4E3540" },
};

/** The colours of the palette in force; one that follows the system is day or dusk. */
export function chartColours(): ChartColours {
  const { palette } = document.documentElement.dataset;
  if (palette === "night") return NIGHT;
  if (palette === "sun") return SUN;
  if (palette === "dusk") return DUSK;
  return palette === "auto" && matchMedia("(prefers-color-scheme: dark)").matches ? DUSK : DAY;
}
