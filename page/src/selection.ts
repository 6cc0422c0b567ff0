// What is selected: a row, or all rows of a surface together.
import type { Contents, Row } from './contents';

export interface Rows {
  names: string[];
  areas: Float64Array;
  surfaceNames: string[]; // empty without a scene
  surfaceOfRow: Int32Array; // -1 where there is none
  polygonsOfRow: Map<number, number[]>;
}

// Form factors from what is selected, of every row.
export interface Selection {
  rows: number[];
  name: string;
  area: number;
  isSum: boolean; // of several rows
  formFactor: Float64Array;
  standardError: Float64Array; // of a sum: at most
  lower?: Float64Array;
  upper?: Float64Array;
  has: Uint8Array; // rows with an entry
}

// Pairs without an entry may have form factors up to a bound of the file; sums with a 0 in place of them have no interval.
export function sumsHaveIntervals({ head }: Contents): boolean {
  return head.has_intervals && head.unlisted_bound === 0;
}

// Returns how far each form factor is from the farther end of its interval.
export function boundsOf({ formFactor, lower, upper }: Selection): Float64Array | undefined {
  return lower && upper && formFactor.map((value, row) => Math.max(value - lower[row], upper[row] - value));
}

// Adds up: F_Ij = sum over i in I of A_i F_ij / A_I. Errors are added as if each were as large as it can be.
export async function select(contents: Contents, rows: Rows, chosen: number[], name: string): Promise<Selection> {
  const count = rows.names.length;
  const area = chosen.reduce((sum, row) => sum + rows.areas[row], 0);
  const hasIntervals = chosen.length > 1 ? sumsHaveIntervals(contents) : contents.head.has_intervals;
  const selection: Selection = {
    rows: chosen, name, area, isSum: chosen.length > 1,
    formFactor: new Float64Array(count), standardError: new Float64Array(count), has: new Uint8Array(count),
    lower: hasIntervals ? new Float64Array(count) : undefined,
    upper: hasIntervals ? new Float64Array(count) : undefined,
  };
  for (const row of chosen) {
    const entries: Row = await contents.row(row);
    const share = chosen.length === 1 ? 1 : area > 0 ? rows.areas[row] / area : 0;
    entries.to.forEach((to, k) => {
      selection.has[to] = 1;
      selection.formFactor[to] += share * entries.formFactor[k];
      selection.standardError[to] += share * entries.standardError[k];
      if (selection.lower && entries.lower) selection.lower[to] += share * entries.lower[k];
      if (selection.upper && entries.upper) selection.upper[to] += share * entries.upper[k];
    });
  }
  return selection;
}

// Adds rows' values up by surface, as means over their areas.
export function meanBySurface(rows: Rows, values: Float64Array): Float64Array {
  const sums = new Float64Array(rows.surfaceNames.length), areas = new Float64Array(rows.surfaceNames.length);
  rows.surfaceOfRow.forEach((surface, row) => {
    if (surface < 0) return;
    sums[surface] += rows.areas[row] * values[row];
    areas[surface] += rows.areas[row];
  });
  return sums.map((sum, surface) => (areas[surface] > 0 ? sum / areas[surface] : 0));
}
