// A Quantity colours the scene: form factors from the selection, or a value of each row.
import type { Kind } from './colours';
import type { Contents } from './contents';

export interface Quantity {
  key: string;
  title: string;
  unit: string; // '' for a number without unit
  kind: Kind;
  centre: number; // neutral value of a diverging scale
  ofSelection: boolean; // whether it is a form factor from the selection, or its error
  values?: Float64Array; // by row
  errors?: Float64Array; // standard errors by row
  bounds?: Float64Array; // a guarantee's bounds on the distance from the true value
  lower?: Float64Array;
  upper?: Float64Array;
}

const COLUMNS: { name: string; title: string; unit: string; kind: Kind; centre?: number }[] = [
  { name: 'environment', title: 'Share to the environment (sky view factor)', unit: '', kind: 'linear' },
  { name: 'environment_up', title: 'Share to the environment above the horizon', unit: '', kind: 'linear' },
  { name: 'environment_down', title: 'Share to the environment below the horizon', unit: '', kind: 'linear' },
  { name: 'leak', title: 'Leak: share that ends on backs', unit: '', kind: 'logarithmic' },
  { name: 'row_sum', title: 'Row sum', unit: '', kind: 'diverging', centre: 1 },
  { name: 'dropped', title: 'Left out by --drop-below', unit: '', kind: 'logarithmic' },
  { name: 'temperature', title: 'Temperature', unit: 'K', kind: 'linear' },
  { name: 'radiosity', title: 'Radiosity', unit: 'W/m\u00b2', kind: 'linear' },
  { name: 'irradiation', title: 'Irradiation', unit: 'W/m\u00b2', kind: 'linear' },
  { name: 'heat_flux', title: 'Net heat flux', unit: 'W/m\u00b2', kind: 'diverging', centre: 0 },
  { name: 'heat_flow', title: 'Net heat flow', unit: 'W', kind: 'diverging', centre: 0 },
];

export async function loadQuantities(contents: Contents): Promise<Quantity[]> {
  const found: Quantity[] = [
    { key: 'form_factor', title: 'Form factor', unit: '', kind: 'logarithmic', centre: 0, ofSelection: true },
    { key: 'standard_error', title: contents.head.is_bounded ? 'Standard error, at most' : 'Standard error', unit: '', kind: 'logarithmic', centre: 0, ofSelection: true },
  ];
  const column = async (name: string) => (contents.has(`column.${name}`) ? ((await contents.array(`column.${name}`)) as Float64Array) : undefined);
  if (contents.head.has_intervals) found.splice(1, 0, { key: 'error_bound', title: 'Error bound', unit: '', kind: 'logarithmic', centre: 0, ofSelection: true });
  for (const { name, title, unit, kind, centre } of COLUMNS) {
    const values = await column(name);
    if (!values) continue;
    found.push({
      key: name, title, unit, kind, centre: centre ?? 0, ofSelection: false, values,
      errors: await column(`${name}_standard_error`), bounds: await column(`${name}_bound`),
      lower: await column(`${name}_lower`), upper: await column(`${name}_upper`),
    });
  }
  return found;
}
