// This file turns values into colours. All colours of the project are in palette.json.
import palette from '../palette.json';

export type Colour = [number, number, number]; // sRGB, 0 to 255

export const parse = (hex: string): Colour => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)) as Colour;
export const css = (colour: Colour): string => `rgb(${colour.map(Math.round).join(' ')})`;
export const NEUTRAL = parse(palette.neutral);
export { palette };

const STEPS = 256;

// Colours between two stops lie on a line in Oklab, where equal steps look equal.
//   Source: B. Ottosson, A perceptual color space for image processing, 2020.
function toOklab(colour: Colour): Colour {
  const [r, g, b] = colour.map((byte) => (byte <= 10.31475 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4));
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

function fromOklab([lightness, a, b]: Colour): Colour {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return linear.map((x) => 255 * Math.min(1, Math.max(0, x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055))) as Colour;
}

// Returns a ramp of 256 colours along the stops, with equal distances in Oklab from one colour to the next.
function makeRamp(hexes: string[]): Colour[] {
  const stops = hexes.map((hex) => toOklab(parse(hex)));
  const lengths = [0];
  for (let k = 1; k < stops.length; ++k) lengths.push(lengths[k - 1] + Math.hypot(...stops[k].map((x, axis) => x - stops[k - 1][axis])));
  const ramp: Colour[] = [];
  for (let step = 0, k = 1; step < STEPS; ++step) {
    const at = (step / (STEPS - 1)) * lengths[lengths.length - 1];
    while (k < stops.length - 1 && lengths[k] < at) ++k;
    const share = (at - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
    ramp.push(fromOklab(stops[k].map((x, axis) => stops[k - 1][axis] + share * (x - stops[k - 1][axis])) as Colour));
  }
  return ramp;
}

const SEQUENTIAL = makeRamp(palette.sequential);
const DIVERGING = makeRamp(palette.diverging);

export type Kind = 'logarithmic' | 'linear' | 'diverging';
const DECADES = 5; // most powers of ten that a logarithmic scale covers

// A Scale maps values to colours.
export class Scale {
  constructor(readonly kind: Kind, readonly least: number, readonly greatest: number) {}

  // Returns a scale for these values. A logarithmic scale ignores values of 0 or less.
  static of(kind: Kind, values: ArrayLike<number>, centre = 0): Scale {
    let least = Infinity, greatest = -Infinity;
    for (let k = 0; k < values.length; ++k) {
      const value = values[k];
      if (!Number.isFinite(value) || (kind === 'logarithmic' && value <= 0)) continue;
      least = Math.min(least, value);
      greatest = Math.max(greatest, value);
    }
    if (!(greatest >= least)) [least, greatest] = kind === 'logarithmic' ? [1e-6, 1] : [0, 1];
    if (kind === 'logarithmic') least = Math.max(least, greatest * 10 ** -DECADES);
    if (kind === 'diverging') {
      const most = Math.max(Math.abs(least - centre), Math.abs(greatest - centre)) || 1e-12;
      [least, greatest] = [centre - most, centre + most];
    }
    if (least === greatest) [least, greatest] = kind === 'logarithmic' ? [least / 2, least * 2] : [least - 0.5 * Math.abs(least || 1), least + 0.5 * Math.abs(least || 1)];
    return new Scale(kind, least, greatest);
  }

  // Returns the place of a value on the ramp, from 0 to 1.
  place(value: number): number {
    const share = this.kind === 'logarithmic' ? Math.log(value / this.least) / Math.log(this.greatest / this.least) : (value - this.least) / (this.greatest - this.least);
    return Math.min(1, Math.max(0, share));
  }

  at(place: number): Colour {
    return (this.kind === 'diverging' ? DIVERGING : SEQUENTIAL)[Math.round(place * (STEPS - 1))];
  }

  // Returns a value's colour; neutral grey for values without a place, such as 0 on a logarithmic scale.
  colour(value: number): Colour {
    if (!Number.isFinite(value) || (this.kind === 'logarithmic' && value <= 0)) return NEUTRAL;
    return this.at(this.place(value));
  }

  // Returns values for the legend: powers of ten, or round steps.
  ticks(): number[] {
    const ticks: number[] = [];
    if (this.kind === 'logarithmic') {
      const first = Math.ceil(Math.log10(this.least) - 1e-9), last = Math.floor(Math.log10(this.greatest) + 1e-9);
      for (let power = first; power <= last; ++power) ticks.push(10 ** power);
      if (ticks.length < 2) return [this.least, this.greatest];
      return ticks;
    }
    const rough = (this.greatest - this.least) / 4, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((x) => x * power).find((x) => x >= rough) ?? rough;
    for (let value = Math.ceil(this.least / step - 1e-9) * step; value <= this.greatest + 1e-9 * step; value += step) ticks.push(Math.abs(value) < 1e-9 * step ? 0 : value);
    return ticks.length > 1 ? ticks : [this.least, this.greatest];
  }
}
