// Panels are tables and charts beside the scene, one at a time behind tabs.
import { drawBars, drawPicture, powerOfTen } from './chart';
import type { Contents } from './contents';
import { asError, byId, copy, counted, element, inDigits } from './format';
import type { Quantity } from './quantities';
import { meanBySurface, type Rows, type Selection, sumsHaveIntervals } from './selection';
import { type Column, Table } from './table';

// Actions are what panels ask the page to do.
export interface Actions {
  chooseRow(row: number): void;
  chooseSurface(surface: number): void;
  say(text: string): void;
}

interface Entry {
  from: string;
  fromRow: number;
  to: string;
  toRow: number;
  formFactor: number;
  standardError: number;
  lower?: number;
  upper?: number;
}

// Returns the distance from a form factor to the farther end of its interval.
function boundOf({ formFactor, lower, upper }: Entry): number {
  return Math.max(formFactor - (lower ?? 0), (upper ?? 0) - formFactor);
}

// Makes tabs that show one panel at a time; arrow keys move between them.
export function makeTabs(titles: string[]): HTMLElement[] {
  const tabs: HTMLButtonElement[] = [], panels: HTMLElement[] = [];
  const show = (shown: number, takeFocus: boolean) => {
    tabs.forEach((tab, k) => {
      tab.setAttribute('aria-selected', String(k === shown));
      tab.tabIndex = k === shown ? 0 : -1;
      panels[k].hidden = k !== shown;
    });
    if (takeFocus) tabs[shown].focus();
  };
  titles.forEach((title, k) => {
    const tab = element('button', { type: 'button', role: 'tab', id: `tab-${k}`, 'aria-controls': `panel-${k}` }, title);
    tab.addEventListener('click', () => show(k, false));
    tab.addEventListener('keydown', (event) => {
      const last = titles.length - 1;
      const next = { ArrowRight: k === last ? 0 : k + 1, ArrowLeft: k === 0 ? last : k - 1, Home: 0, End: last }[event.key];
      if (next === undefined) return;
      event.preventDefault();
      show(next, true);
    });
    tabs.push(tab);
    panels.push(element('div', { role: 'tabpanel', id: `panel-${k}`, 'aria-labelledby': `tab-${k}`, class: 'panel' }));
  });
  byId('tabs').append(...tabs);
  byId('panels').append(...panels);
  show(0, false);
  return panels;
}

// Returns the columns of a table of form factors, in the order and with the names of a .csv.
function entryColumns({ hasIntervals, isBounded }: { hasIntervals: boolean; isBounded: boolean }): Column<Entry>[] {
  const number = (key: string, title: string, value: (entry: Entry) => number, inWords = (entry: Entry) => inDigits(value(entry))): Column<Entry> => ({ key, title, isNumber: true, value, text: inWords });
  const columns: Column<Entry>[] = [
    { key: 'from', title: 'From', isNumber: false, value: (entry) => entry.from, text: (entry) => entry.from },
    { key: 'to', title: 'To', isNumber: false, value: (entry) => entry.to, text: (entry) => entry.to },
    number('form_factor', 'Form factor', (entry) => entry.formFactor),
    number(isBounded ? 'standard_error_at_most' : 'standard_error', hasIntervals ? '' : isBounded ? 'Standard error, at most' : 'Standard error', (entry) => entry.standardError, (entry) => asError(entry.standardError)),
  ];
  if (hasIntervals) columns.push(number('lower', 'Lower', (entry) => entry.lower ?? 0), number('upper', 'Upper', (entry) => entry.upper ?? 0));
  return columns;
}

function columnsOf({ head }: Contents): Column<Entry>[] {
  return entryColumns({ hasIntervals: head.has_intervals, isBounded: head.is_bounded });
}

// --- the selection ---
export function makeSelectionPanel(panel: HTMLElement, contents: Contents, rows: Rows, quantities: Quantity[], actions: Actions): (selection?: Selection) => void {
  const choose = (entry: Entry) => actions.chooseRow(entry.toRow);
  const make = (columns: Column<Entry>[]) => new Table<Entry>(columns.slice(1), 'Form factors from what is selected', { sorted: 'form_factor', choose, say: actions.say });
  const ofRow = make(columnsOf(contents)), ofSum = make(entryColumns({ hasIntervals: sumsHaveIntervals(contents), isBounded: true }));
  const title = element('h2'), facts = element('dl', { class: 'facts' });
  const hint = element('p', { class: 'hint' }, 'Click a polygon of the scene, or a name in a table.');
  panel.append(title, facts, hint, ofRow.root, ofSum.root);
  return (selection) => {
    hint.hidden = selection !== undefined;
    facts.hidden = selection === undefined;
    ofRow.root.hidden = selection === undefined || selection.isSum;
    ofSum.root.hidden = !selection?.isSum;
    title.textContent = selection ? `From ${selection.name}` : 'Nothing is selected';
    if (!selection) return;
    const lines: [string, string][] = [['Area', inDigits(selection.area)]];
    if (selection.isSum) lines.push(['Rows', `${selection.rows.length}, added up${selection.lower ? '' : '; standard errors are at most as stated'}`]);
    else
      for (const quantity of quantities)
        if (quantity.values) lines.push([quantity.title, valueInWords(quantity, selection.rows[0])]);
    facts.replaceChildren(...lines.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]));
    const entries: Entry[] = [];
    selection.has.forEach((has, row) => {
      if (!has) return;
      entries.push({ from: selection.name, fromRow: selection.rows[0], to: rows.names[row], toRow: row, formFactor: selection.formFactor[row],
        standardError: selection.standardError[row], lower: selection.lower?.[row], upper: selection.upper?.[row] });
    });
    (selection.isSum ? ofSum : ofRow).show(entries);
  };
}

export function valueInWords(quantity: Quantity, row: number): string {
  const value = quantity.values?.[row] ?? NaN, unit = quantity.unit ? ` ${quantity.unit}` : '';
  if (quantity.lower && quantity.upper) return `${inDigits(value)}, in [${inDigits(quantity.lower[row])}, ${inDigits(quantity.upper[row])}]${unit}`;
  const error = quantity.errors?.[row] ? ` \u00b1 ${asError(quantity.errors[row])}` : '';
  const bound = quantity.bounds ? `, within ${asError(quantity.bounds[row])}` : '';
  return `${inDigits(value)}${error}${bound}${unit}`;
}

// --- the largest of all ---
async function loadEntries(contents: Contents, rows: Rows, list: string): Promise<Entry[]> {
  const part = (name: string) => contents.array(`${list}.${name}`);
  const [from, to, formFactor, standardError] = await Promise.all([part('from'), part('to'), part('form_factor'), part('standard_error')]);
  const [lower, upper] = contents.head.has_intervals ? await Promise.all([part('lower'), part('upper')]) : [];
  return Array.from(from, (row, k) => ({ from: rows.names[row], fromRow: row, to: rows.names[to[k]], toRow: to[k], formFactor: formFactor[k], standardError: standardError[k], lower: lower?.[k], upper: upper?.[k] }));
}

export async function makeLargestPanel(panel: HTMLElement, contents: Contents, rows: Rows, actions: Actions): Promise<void> {
  const entries = await loadEntries(contents, rows, 'largest');
  const all = contents.head.entries;
  const table = new Table<Entry>(columnsOf(contents), 'Largest form factors', { sorted: 'form_factor', choose: (entry) => actions.chooseRow(entry.fromRow), say: actions.say });
  table.show(entries);
  panel.append(element('h2', {}, 'Largest form factors'));
  if (entries.length < all) panel.append(element('p', { class: 'hint' }, `These are the largest ${counted(entries.length, 'form factor')} of ${all.toLocaleString('en-US')}. A click on a name shows all of its own.`));
  panel.append(table.root);
}

// --- surfaces, the leaking ones first ---
interface Part {
  index: number;
  name: string;
  area: number;
  leak: number;
  environment: number;
  off: number;
}

export function makeSurfacesPanel(panel: HTMLElement, rows: Rows, quantities: Quantity[], actions: Actions): void {
  const bySurface = rows.surfaceNames.length > 0;
  const valuesOf = (key: string) => {
    const values = quantities.find((quantity) => quantity.key === key)?.values;
    return values && bySurface ? meanBySurface(rows, values) : values;
  };
  const leak = valuesOf('leak'), environment = valuesOf('environment'), sums = valuesOf('row_sum');
  const names = bySurface ? rows.surfaceNames : rows.names;
  const areas = bySurface ? new Float64Array(names.length) : rows.areas;
  if (bySurface) rows.surfaceOfRow.forEach((surface, row) => surface >= 0 && (areas[surface] += rows.areas[row]));
  const parts: Part[] = names.map((name, index) => ({ index, name, area: areas[index], leak: leak?.[index] ?? 0, environment: environment?.[index] ?? 0, off: sums && areas[index] > 0 && sums[index] > 0 ? sums[index] - 1 : 0 }));
  const number = (key: string, title: string, value: (part: Part) => number, text = (part: Part) => inDigits(value(part), 4)): Column<Part> => ({ key, title, isNumber: true, value, text });
  const columns: Column<Part>[] = [
    { key: bySurface ? 'surface' : 'row', title: bySurface ? 'Surface' : 'Row', isNumber: false, value: (part) => part.name, text: (part) => part.name },
    number('leak', 'Leak', (part) => part.leak),
    number('environment', 'Environment', (part) => part.environment),
    number('row_sum_less_1', 'Row sum less 1', (part) => part.off, (part) => asError(part.off)),
    number('area', 'Area', (part) => part.area),
  ];
  const choose = (part: Part) => (bySurface ? actions.chooseSurface(part.index) : actions.chooseRow(part.index));
  const table = new Table<Part>(columns, 'Surfaces, those that leak first', { sorted: 'leak', choose, say: actions.say });
  table.show(parts);
  const leaking = parts.filter((part) => part.leak > LEAK_THAT_COUNTS).length;
  const sentence = leaking
    ? `${counted(leaking, 'surface')} ${leaking === 1 ? 'loses' : 'lose'} radiation to the backs of others (leak). A face that looks the wrong way shows its back, hatched, where a front should be; it is solid where another back is before it.`
    : 'No surface leaks: no radiation ends on a back.';
  panel.append(element('h2', {}, 'Surfaces'), element('p', { class: leaking ? 'hint warn' : 'hint' }, sentence), table.root);
}

// In a closed scene up to 1e-7 of all lines graze an edge and count as leak (docs/limits.md).
export const LEAK_THAT_COUNTS = 1e-6;

// --- errors and closure ---
export async function makeErrorsPanel(panel: HTMLElement, contents: Contents, rows: Rows, quantities: Quantity[], goal: Goal | undefined, actions: Actions): Promise<void> {
  const { errors, has_intervals: hasIntervals } = contents.head;
  panel.append(element('h2', {}, hasIntervals ? 'Error bounds' : 'Standard errors'));
  if (hasIntervals) panel.append(element('p', { class: 'hint' }, 'An error bound is the distance of a form factor from the farther end of its interval.'));
  const marks = goal ? [{ at: Math.log10(goal.value), text: `goal ${inDigits(goal.value, 3)}` }] : [];
  if (errors.bins.length)
    panel.append(drawBars({ title: `Form factors by the power of ten of their ${hasIntervals ? 'error bound' : 'standard error'}`, first: errors.first, step: errors.step, counts: errors.bins, noun: 'form factor', tick: powerOfTen, marks }));
  const lines: [string, string][] = [['Largest', asError(errors.largest ?? NaN)], ['Root mean square', asError(errors.rms ?? NaN)]];
  if (errors.without) lines.push(['Without error', counted(errors.without, 'form factor')]);
  if (goal) lines.push([goal.name, inDigits(goal.value)]);
  panel.append(element('dl', { class: 'facts' }, ...lines.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)])));
  panel.append(element('p', { class: 'hint' }, 'Heights are square roots of counts.'));

  const sums = quantities.find((quantity) => quantity.key === 'row_sum');
  const requested = contents.has('column.is_requested') ? await contents.array('column.is_requested') : undefined;
  const counting = rows.names.map((_, row) => row).filter((row) => rows.areas[row] > 0 && (!requested || requested[row] > 0));
  panel.append(element('h2', {}, 'Closure: distance of row sums from 1'));
  if (!sums?.values || counting.length === 0) panel.append(element('p', { class: 'hint' }, 'The file has no row sums.'));
  else drawClosure(panel, sums, counting, rows, actions);

  const worst = await loadEntries(contents, rows, 'worst');
  const noun = hasIntervals ? 'error bound' : 'standard error', columns = columnsOf(contents);
  if (hasIntervals) columns.push({ key: 'error_bound', title: 'Error bound', isNumber: true, value: boundOf, text: (entry) => asError(boundOf(entry)) });
  const sorted = hasIntervals ? 'error_bound' : columns[3].key;
  const table = new Table<Entry>(columns, `Form factors with the largest ${noun}s`, { sorted, choose: (entry) => actions.chooseRow(entry.fromRow), say: actions.say });
  table.show(worst);
  panel.append(element('h2', {}, worst.length === 1 ? `The ${noun}` : `The ${counted(worst.length, `largest ${noun}`)}`), table.root);
}

export interface Goal {
  name: string;
  value: number;
}

function drawClosure(panel: HTMLElement, sums: Quantity, counting: number[], rows: Rows, actions: Actions): void {
  const values = sums.values as Float64Array;
  const off = counting.map((row) => values[row] - 1);
  const most = off.reduce((greatest, value) => Math.max(greatest, Math.abs(value)), 0), bins = 24;
  const step = (2 * (most || 1e-12)) / bins;
  const counts = new Array<number>(bins).fill(0);
  for (const value of off) ++counts[Math.min(bins - 1, Math.max(0, Math.floor((value + bins * step * 0.5) / step)))];
  const tick = (at: number) => (Math.abs(Math.round(at / step / 6) - at / step / 6) < 1e-6 ? (Math.abs(at) < step / 2 ? '0' : at.toExponential(1)) : undefined);
  panel.append(drawBars({ title: 'Rows by their sum less 1', first: (-bins / 2) * step, step, counts, noun: 'row', tick, marks: [] }));
  const worst = counting.slice().sort((a, b) => Math.abs(values[b] - 1) - Math.abs(values[a] - 1)).slice(0, 100);
  const table = new Table<number>(
    [
      { key: 'row', title: 'Row', isNumber: false, value: (row) => rows.names[row], text: (row) => rows.names[row] },
      { key: 'row_sum_less_1', title: 'Sum less 1', isNumber: true, value: (row) => values[row] - 1, text: (row) => asError(values[row] - 1), rank: (row) => Math.abs(values[row] - 1) },
      { key: 'standard_error', title: 'Standard error', isNumber: true, value: (row) => sums.errors?.[row] ?? 0, text: (row) => asError(sums.errors?.[row] ?? 0) },
    ],
    'Rows whose sums are farthest from 1', { sorted: 'row_sum_less_1', choose: actions.chooseRow, say: actions.say });
  table.show(worst);
  panel.append(table.root);
}

// --- the matrix ---
export async function makeMatrixPanel(panel: HTMLElement, contents: Contents, rows: Rows, actions: Actions): Promise<void> {
  const size = contents.head.picture_size;
  const ranks = await contents.integers('rank');
  const values = (await contents.array('picture')) as Float32Array;
  const order = new Int32Array(ranks.length);
  ranks.forEach((rank, row) => (order[rank] = row));
  const rowsOf = (cell: number) => {
    const first = Math.ceil((cell * ranks.length) / size);
    return { first: order[first], others: Math.ceil(((cell + 1) * ranks.length) / size) - first - 1 };
  };
  const inWords = (cell: number) => {
    const { first, others } = rowsOf(cell);
    return rows.names[first] + (others > 0 ? ` and ${counted(others, 'row')}` : '');
  };
  const describe = (down: number, across: number) => `${inWords(down)} to ${inWords(across)}: ${values[down * size + across] > 0 ? `${size < ranks.length ? 'up to ' : ''}${inDigits(values[down * size + across], 4)}` : '0 or none'}`;
  const { entries } = contents.head, share = (100 * entries) / Math.max(1, rows.names.length ** 2);
  panel.append(element('h2', {}, 'Matrix'), element('p', { class: 'hint' }, `${counted(entries, 'nonzero form factor')}, ${inDigits(share, 3)} % of ${rows.names.length} x ${rows.names.length}. A click selects the row.`),
    drawPicture(values, size, describe, (down) => actions.chooseRow(rowsOf(down).first)));
}

// --- the run ---
export function makeRunPanel(panel: HTMLElement, parameters: Map<string, string>, notes: string[], actions: Actions): void {
  panel.append(element('h2', {}, 'Run'));
  const command = parameters.get('command');
  if (command) {
    const button = element('button', { type: 'button' }, 'Copy');
    button.addEventListener('click', () => void copy(command).then((done) => actions.say(done ? 'Copied the command.' : 'The browser does not allow copying here.')));
    panel.append(element('p', { class: 'hint' }, 'This command repeats the run, to the same bits on any device:'), element('div', { class: 'command' }, element('code', {}, ...command.split(/(?<= )/).map((word) => element('span', {}, word))), button));
  } else panel.append(element('p', { class: 'hint' }, 'The file does not say which command made it.'));
  for (const note of notes) panel.append(element('p', { class: 'hint warn' }, note));
  const lines = [...parameters].filter(([name]) => name !== 'command' && name !== 'viewpeel_result_format');
  const body = element('tbody', {}, ...lines.map(([name, value]) => element('tr', {}, element('th', { scope: 'row' }, name), element('td', {}, value))));
  panel.append(element('table', { class: 'parameters' }, element('caption', { class: 'unseen' }, 'Parameters of the run'), body));
}
