/** Colour maps: a few colours, evenly spaced from the lowest value to the highest. Both ends differ in lightness or hue for all eyes. */

export type Rgb = readonly [number, number, number];
export type ColourMapName = 'error' | 'stretch' | 'gaps' | 'confidence' | 'mask' | 'picture';

const MAPS: Record<ColourMapName, readonly string[]> = {
  error: ['#3b4cc0', '#4f8fd0', '#73c0c4', '#b8dcae', '#f3e79b', '#f8b15e', '#e0603c', '#a31a2b'],
  stretch: ['#2b5ea8', '#6a9bd0', '#b4cde6', '#eeeeee', '#f3c7a1', '#de8652', '#a8421f'],
  gaps: ['#e9e4f2', '#c2b1dc', '#9a7bc4', '#7347a8', '#4b1c7d'],
  confidence: ['#b3261e', '#e06c3a', '#efb35a', '#d9d98a', '#8bc39a', '#2f8f83'],
  mask: ['#d5d9de', '#f3c98a', '#f09a3e', '#d9611b'],
  // The scale of the still pictures of reports, at eighths.
  picture: ['#f1eddd', '#e7cea0', '#dcae5e', '#d7863d', '#cf5a15', '#b23c33', '#95163e', '#641b46', '#361249'],
};

export const COLOUR_MAPS = Object.keys(MAPS) as ColourMapName[];

export function parseColour(hex: string): Rgb {
  const number = Number.parseInt(hex.slice(1), 16);
  return [((number >> 16) & 255) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255];
}

/** The colour at `t` from 0 to 1; values outside take the colour of the nearer end. */
export function sampleColour(name: ColourMapName, t: number): Rgb {
  const stops = MAPS[name];
  const place = Math.min(Math.max(t, 0), 1) * (stops.length - 1);
  const index = Math.min(Math.floor(place), stops.length - 2);
  const rest = place - index;
  const [a, b] = [parseColour(stops[index]), parseColour(stops[index + 1])];
  return [a[0] + (b[0] - a[0]) * rest, a[1] + (b[1] - a[1]) * rest, a[2] + (b[2] - a[2]) * rest];
}

/** `size` colours of a map as bytes, red green blue alpha. */
export function colourTable(name: ColourMapName, size: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(size * 4);
  for (let i = 0; i < size; i++) {
    const [r, g, b] = sampleColour(name, i / (size - 1));
    bytes.set([Math.round(r * 255), Math.round(g * 255), Math.round(b * 255), 255], i * 4);
  }
  return bytes;
}

export function cssColour([r, g, b]: Rgb): string {
  return `rgb(${Math.round(r * 255)} ${Math.round(g * 255)} ${Math.round(b * 255)})`;
}

/**
 * Limits of a legend for values: round numbers, so that the ticks can be read. Values far above the rest, beyond `quantile`, do not
 * stretch the limits; they show in the colour of the end.
 */
export function legendRange(values: Float32Array, quantile = 0.995): [number, number] {
  const finite = values.filter(Number.isFinite).sort();
  if (finite.length === 0) return [0, 1];
  const low = finite[0];
  const high = finite[Math.min(finite.length - 1, Math.floor(finite.length * quantile))];
  if (low >= 0) return [0, niceCeil(high) || 1];
  const reach = niceCeil(Math.max(-low, high));
  return [-reach, reach];
}

function niceCeil(value: number): number {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  for (const step of [1, 1.5, 2, 3, 4, 5, 6, 8, 10]) {
    if (value <= step * power * (1 + 1e-9)) return step * power;
  }
  return 10 * power;
}

/** A few round values from `low` to `high`. */
export function ticks(low: number, high: number, count = 5): number[] {
  return Array.from({ length: count }, (_, i) => low + ((high - low) * i) / (count - 1));
}

export function formatNumber(value: number): string {
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(1);
  return String(Number(value.toPrecision(3)));
}
