// This file opens the page: it reads the contents, draws the scene, fills the panels, and explains a damaged page.
import { gradient } from './chart';
import { NEUTRAL, palette, Scale } from './colours';
import { Contents, Fault } from './contents';
import { asError, byId, counted, element, inDigits } from './format';
import { type Goal, LEAK_THAT_COUNTS, makeErrorsPanel, makeLargestPanel, makeMatrixPanel, makeRunPanel, makeSelectionPanel, makeSurfacesPanel, makeTabs, valueInWords } from './panels';
import { loadQuantities, type Quantity } from './quantities';
import { type Backs, Scene } from './scene';
import { boundsOf, type Rows, select, type Selection } from './selection';

class Page {
  private selection?: Selection;
  private quantity: Quantity;
  private showSelection: (selection?: Selection) => void = () => {};
  private hovered?: { polygon: number; x: number; y: number };
  private asked = 0; // number of selections begun so far

  constructor(
    private readonly contents: Contents, private readonly rows: Rows, private readonly quantities: Quantity[], private readonly parameters: Map<string, string>,
    private readonly notes: string[], private readonly rowOfPolygon: Int32Array, private readonly surfaceOfPolygon: Int32Array, readonly scene: Scene | undefined,
  ) {
    this.quantity = quantities.find(({ key }) => key === 'temperature') ?? quantities[0];
  }

  async start(): Promise<void> {
    this.addFacts();
    this.addTools();
    const panels = makeTabs(['Selection', 'Largest', 'Surfaces', 'Errors', 'Matrix', 'Run']);
    const actions = {
      chooseRow: (row: number) => void this.choose([row], this.rows.names[row]),
      chooseSurface: (surface: number) => void this.chooseSurface(surface),
      say: (text: string) => this.say(text),
    };
    this.showSelection = makeSelectionPanel(panels[0], this.contents, this.rows, this.quantities, actions);
    this.showSelection();
    makeSurfacesPanel(panels[2], this.rows, this.quantities, actions);
    makeRunPanel(panels[5], this.parameters, this.notes, actions);
    this.listen();
    await Promise.all([
      this.choose([this.firstRow()], this.rows.names[this.firstRow()]),
      makeLargestPanel(panels[1], this.contents, this.rows, actions),
      makeErrorsPanel(panels[3], this.contents, this.rows, this.quantities, this.goal(), actions),
      makeMatrixPanel(panels[4], this.contents, this.rows, actions),
    ]);
  }

  // Returns the name of the row at a point of the window.
  nameAt(x: number, y: number): string | undefined {
    const polygon = this.scene?.pick(x, y);
    return polygon === undefined ? undefined : this.rows.names[this.rowOfPolygon[polygon]];
  }

  // Selects the row with this name.
  async chooseName(name: string): Promise<void> {
    const row = this.rows.names.indexOf(name);
    if (row >= 0) await this.choose([row], name);
  }

  say(text: string): void {
    byId('said').textContent = text;
  }

  private goal(): Goal | undefined {
    for (const [parameter, name] of [['tolerance', 'Goal: --tolerance'], ['epsilon', 'Goal: --epsilon']]) {
      const value = Number(this.parameters.get(parameter));
      if (value > 0) return { name, value };
    }
    return undefined;
  }

  // Returns the row that sends most to other rows, so that the first picture shows many colours.
  private firstRow(): number {
    const environment = this.quantities.find(({ key }) => key === 'environment')?.values;
    let best = 0, most = -1;
    this.rows.areas.forEach((area, row) => {
      const sent = area * (1 - (environment?.[row] ?? 0));
      if (sent > most) [best, most] = [row, sent];
    });
    return best;
  }

  private addFacts(): void {
    const { head } = this.contents;
    const file = this.parameters.get('scene_file');
    byId('title').textContent = file ? `Form factors of ${file}` : 'Form factors';
    document.title = file ? `${file}: form factors` : 'Form factors';
    const facts = [
      ...(this.rowOfPolygon.length ? [counted(this.rowOfPolygon.length, 'polygon')] : []),
      ...(this.rows.surfaceNames.length ? [counted(this.rows.surfaceNames.length, 'surface')] : []),
      counted(head.entries_of_file, 'form factor'),
      `largest ${head.has_intervals ? 'error bound' : 'standard error'} ${asError(head.errors.largest ?? NaN)}`,
      ...(this.parameters.has('closure_largest') ? [`rows within ${asError(Number(this.parameters.get('closure_largest')))} of 1`] : []),
      this.leaks() ? 'some surfaces leak' : 'no leak',
    ];
    byId('facts').replaceChildren(...facts.map((fact) => element('li', {}, fact)));
    byId('warning').hidden = this.notes.length === 0;
    byId('warning').textContent = this.notes.join(' ');
  }

  private leaks(): boolean {
    return this.quantities.find(({ key }) => key === 'leak')?.values?.some((value) => value > LEAK_THAT_COUNTS) ?? false;
  }

  private addTools(): void {
    const quantities = byId<HTMLSelectElement>('quantity');
    quantities.replaceChildren(...this.quantities.map(({ key, title, ofSelection }) => element('option', { value: key }, ofSelection ? `${title} from the selection` : title)));
    quantities.value = this.quantity.key;
    quantities.addEventListener('change', () => {
      this.quantity = this.quantities.find(({ key }) => key === quantities.value) ?? this.quantities[0];
      this.paint();
    });
    byId('tools').addEventListener('submit', (event) => event.preventDefault());
    // Where rows are surfaces, single polygons cannot be selected.
    byId('unit-label').hidden = this.rows.surfaceNames.length === 0 || this.rows.names.length === this.rows.surfaceNames.length;
    const backs = byId<HTMLSelectElement>('backs');
    const setBacks = () => this.scene?.setBacks(backs.value as Backs);
    // Where lines end on backs, backs are hatched so that they are easy to find.
    backs.value = this.leaks() ? 'hatched' : 'dotted';
    setBacks();
    backs.addEventListener('change', setBacks);
    byId<HTMLSelectElement>('up').addEventListener('change', (event) => this.scene?.setUp((event.target as HTMLSelectElement).value as 'x' | 'y' | 'z'));
    byId('home').addEventListener('click', () => this.scene?.showAll());
  }

  private listen(): void {
    const dark = window.matchMedia('(prefers-color-scheme: dark)');
    const setInk = () => this.scene?.setInk(dark.matches ? palette.dark.ink : palette.light.ink);
    dark.addEventListener('change', setInk);
    setInk();
    byId('scene').addEventListener('keydown', (event) => {
      const count = this.rows.names.length, at = this.selection?.rows[0] ?? -1;
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === 'n') void this.choose([(at + 1) % count], this.rows.names[(at + 1) % count]);
      else if (event.key === 'p') void this.choose([(at + count - 1) % count], this.rows.names[(at + count - 1) % count]);
      else if (event.key === 'Escape') this.chooseNothing();
      else return;
      event.preventDefault();
    });
    if (!this.scene) return;
    this.scene.onPick = (polygon) => {
      if (polygon === undefined) return;
      const row = this.rowOfPolygon[polygon];
      if (byId<HTMLSelectElement>('unit').value === 'surface' && !byId('unit-label').hidden) void this.chooseSurface(this.surfaceOfPolygon[polygon]);
      else void this.choose([row], this.rows.names[row]);
    };
    this.scene.onHover = (polygon, x, y) => this.showTip(polygon, x, y);
  }

  private async chooseSurface(surface: number): Promise<void> {
    const rows: number[] = [];
    this.rows.surfaceOfRow.forEach((of, row) => of === surface && rows.push(row));
    if (rows.length) await this.choose(rows, this.rows.surfaceNames[surface]);
  }

  private async choose(rows: number[], name: string): Promise<void> {
    const asked = ++this.asked;
    try {
      const selection = await select(this.contents, this.rows, rows, name);
      if (asked !== this.asked) return; // a later selection has begun meanwhile
      this.selection = selection;
    } catch (error) {
      showFault(error);
      return;
    }
    this.showSelection(this.selection);
    this.scene?.outline(rows.flatMap((row) => this.rows.polygonsOfRow.get(row) ?? []));
    this.paint();
    if (this.hovered) this.showTip(this.hovered.polygon, this.hovered.x, this.hovered.y);
    this.say(`Selected ${name}: ${counted(this.selection.has.reduce((sum, has) => sum + has, 0), 'form factor')}.`);
  }

  private chooseNothing(): void {
    ++this.asked;
    this.selection = undefined;
    this.showSelection();
    this.scene?.outline([]);
    this.paint();
    this.say('Nothing is selected.');
  }

  private valuesShown(): Float64Array | undefined {
    if (!this.quantity.ofSelection) return this.quantity.values;
    if (!this.selection) return undefined;
    const { key } = this.quantity;
    return key === 'form_factor' ? this.selection.formFactor : key === 'error_bound' ? boundsOf(this.selection) : this.selection.standardError;
  }

  private paint(): void {
    const values = this.valuesShown();
    const scale = Scale.of(this.quantity.kind, values ?? [], this.quantity.centre);
    const colours = values ? Array.from(values, (value) => scale.colour(value)) : undefined;
    this.scene?.paint((polygon) => colours?.[this.rowOfPolygon[polygon]] ?? NEUTRAL);
    this.drawLegend(scale, values);
  }

  private drawLegend(scale: Scale, values?: Float64Array): void {
    const { title, unit, ofSelection } = this.quantity;
    byId('legend-title').textContent = `${title}${ofSelection && this.selection ? ` from ${this.selection.name}` : ''}${unit ? `, ${unit}` : ' (no unit)'}`;
    byId('ramp').style.background = gradient(scale);
    byId('ticks').replaceChildren(
      ...scale.ticks().map((tick) => {
        const mark = element('span', {}, inDigits(tick, 3));
        mark.style.left = `${100 * scale.place(tick)}%`;
        return mark;
      }));
    const notes: string[] = [];
    if (scale.kind === 'logarithmic' && values) {
      if (values.some((value) => value > 0 && value < scale.least)) notes.push(`smaller ones as ${inDigits(scale.least, 2)}`);
      notes.push('grey: 0 or none');
    }
    if (!values) notes.push(this.selection ? 'sums of these form factors have no intervals' : 'nothing is selected');
    byId('legend-notes').textContent = notes.join('; ');
    byId('scene').setAttribute('aria-label', `Scene, coloured by ${byId('legend-title').textContent}, from ${inDigits(scale.least, 3)} to ${inDigits(scale.greatest, 3)}`);
  }

  private showTip(polygon: number | undefined, x: number, y: number): void {
    const tip = byId('tip');
    this.hovered = polygon === undefined ? undefined : { polygon, x, y };
    tip.hidden = polygon === undefined;
    if (polygon === undefined) return;
    const row = this.rowOfPolygon[polygon];
    const lines = [element('strong', {}, this.rows.names[row])];
    const add = (text: string) => lines.push(element('span', {}, text));
    const selection = this.selection;
    if (selection) add(`F from ${selection.name}: ${this.inWords(selection, row)}`);
    if (!this.quantity.ofSelection) add(`${this.quantity.title}: ${valueInWords(this.quantity, row)}`);
    add(`area ${inDigits(this.rows.areas[row])}`);
    tip.replaceChildren(...lines);
    const stage = byId('stage').getBoundingClientRect();
    tip.style.left = `${Math.max(4, Math.min(x - stage.left + 14, stage.width - tip.offsetWidth - 6))}px`;
    tip.style.top = `${Math.max(4, Math.min(y - stage.top + 14, stage.height - tip.offsetHeight - 6))}px`;
  }

  private inWords(selection: Selection, row: number): string {
    if (!selection.has[row]) return 'none';
    const f = inDigits(selection.formFactor[row]);
    if (selection.lower && selection.upper) return `${f}, in [${inDigits(selection.lower[row])}, ${inDigits(selection.upper[row])}]`;
    const isAtMost = selection.isSum || this.contents.head.is_bounded;
    return `${f} \u00b1 ${isAtMost ? 'at most ' : ''}${asError(selection.standardError[row])}`;
  }
}

// Shows in a sentence what is wrong with the page.
function showFault(error: unknown): void {
  const fault = byId('fault');
  fault.textContent = error instanceof Fault ? error.message : `This page cannot show its result: ${error instanceof Error ? error.message : String(error)}`;
  fault.hidden = false;
  byId('waiting').hidden = true;
}

async function loadRows(contents: Contents, rowOfPolygon: Int32Array, surfaceOfPolygon: Int32Array): Promise<Rows> {
  const [names, areas, surfaceNames] = await Promise.all([contents.texts('name'), contents.array('area'), contents.head.has_scene ? contents.texts('surface_name') : []]);
  const rows: Rows = {
    names, areas: areas as Float64Array, surfaceNames,
    surfaceOfRow: new Int32Array(names.length).fill(-1),
    polygonsOfRow: new Map(),
  };
  rowOfPolygon.forEach((row, polygon) => {
    rows.surfaceOfRow[row] = surfaceOfPolygon[polygon];
    const polygons = rows.polygonsOfRow.get(row);
    if (polygons) polygons.push(polygon);
    else rows.polygonsOfRow.set(row, [polygon]);
  });
  return rows;
}

// Makes the scene. Where there is none, it shows the reason and returns nothing.
async function makeScene(contents: Contents): Promise<Scene | undefined> {
  let reason = 'The file has no polygons, so that there is no scene to show; tables and charts are complete.';
  if (contents.head.has_scene) {
    try {
      return await Scene.make(contents, byId<HTMLCanvasElement>('scene'));
    } catch (error) {
      if (error instanceof Fault) throw error;
      reason = 'This browser cannot draw the scene (no WebGL 2); tables and charts are complete.';
    }
  }
  byId('no-scene').textContent = reason;
  byId('no-scene').hidden = false;
  byId('view').classList.add('without');
  return undefined;
}

async function open(): Promise<void> {
  const contents = new Contents();
  await contents.open();
  byId('app').hidden = false;
  const none = new Int32Array(0);
  // Contents that do not depend on each other are read together.
  const [rowOfPolygon, surfaceOfPolygon, words, notes, quantities, scene] = await Promise.all([
    contents.head.has_scene ? contents.integers('row_of_polygon') : none, contents.head.has_scene ? contents.integers('surface_of_polygon') : none,
    contents.texts('parameters'), contents.texts('notes'), loadQuantities(contents), makeScene(contents),
  ]);
  const rows = await loadRows(contents, rowOfPolygon, surfaceOfPolygon);
  const parameters = new Map<string, string>();
  for (let k = 0; k + 1 < words.length; k += 2) parameters.set(words[k], words[k + 1]);
  const page = new Page(contents, rows, quantities, parameters, notes, rowOfPolygon, surfaceOfPolygon, scene);
  await page.start();
  byId('waiting').hidden = true;
  document.body.dataset.state = 'ready';
  Object.assign(window, { viewpeelPage: page }); // for the browser's console and for tests
}

document.addEventListener('DOMContentLoaded', () => {
  open().catch((error) => {
    byId('app').hidden = true;
    showFault(error);
  });
});
