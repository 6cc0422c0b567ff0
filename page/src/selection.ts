// This file selects rows of the matrix, one row or all rows of a surface together, and adds up their form factors.
import type { Contents, Row } from './contents';

export interface Rows {
  names: string[];
  areas: Float64Array;
  surfaceNames: string[]; // empty without a scene
  surfaceOfRow: Int32Array; // -1 for rows without a surface
  polygonsOfRow: Map<number, number[]>;
}

// A Selection has form factors from the selected rows to every row.
export interface Selection {
  rows: number[];
  name: string;
  area: number;
  isSum: boolean; // whether several rows are selected
  formFactor: Float64Array;
  standardError: Float64Array; // for a sum an upper bound
  lower?: Float64Array;
  upper?: Float64Array;
  has: Uint8Array; // by row: 1 where it has an entry
}

// Returns whether sums of form factors have intervals: not where a pair without an entry may be above 0.
export function sumsHaveIntervals({ head }: Contents): boolean {
  return head.has_intervals && head.unlisted_bound === 0;
}

// Returns the distance from each form factor to the farther end of its interval.
export function boundsOf({ formFactor, lower, upper }: Selection): Float64Array | undefined {
  return lower && upper && formFactor.map((value, row) => Math.max(value - lower[row], upper[row] - value));
}

// Selects rows and adds up their form factors: F_Ij = sum over i in I of A_i F_ij / A_I, with A_I the sum of the A_i.
// The same sum of standard errors bounds the standard error of F_Ij, whatever the correlation of the F_ij.
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

// Returns the mean of rows' values over each surface, weighted by area.
export function meanBySurface(rows: Rows, values: Float64Array): Float64Array {
  const sums = new Float64Array(rows.surfaceNames.length), areas = new Float64Array(rows.surfaceNames.length);
  rows.surfaceOfRow.forEach((surface, row) => {
    if (surface < 0) return;
    sums[surface] += rows.areas[row] * values[row];
    areas[surface] += rows.areas[row];
  });
  return sums.map((sum, surface) => (areas[surface] > 0 ? sum / areas[surface] : 0));
}
