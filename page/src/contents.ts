// Contents reads what host/report/write_page.cpp packed into the page. Each array is decoded when it is first needed.

type Bytes = Uint8Array<ArrayBuffer>;
type Values = Bytes | Int32Array | Float32Array | Float64Array;
const TYPES = { u8: Uint8Array, i32: Int32Array, f32: Float32Array, f64: Float64Array, text: Uint8Array };

interface Head {
  format: number;
  rows: number;
  entries: number;
  rows_of_file: number;
  entries_of_file: number;
  has_scene: boolean;
  has_intervals: boolean;
  unlisted_bound: number; // a guarantee's bound on form factors without an entry
  is_bounded: boolean;
  is_rounded: boolean;
  middle: [number, number, number];
  picture_size: number;
  // `errors` is a histogram over powers of ten: of error bounds where there are intervals, else of standard errors.
  errors: { first: number; step: number; without: number; largest: number | null; rms: number | null; bins: number[] };
  columns: { name: string; unit: string }[];
  arrays: { name: string; type: keyof typeof TYPES; count: number }[];
}

// A Row is the form factors of one row.
export interface Row {
  to: Int32Array;
  formFactor: Values;
  standardError: Values;
  lower?: Values;
  upper?: Values;
}

// A Fault is a message to readers of a damaged page.
export class Fault extends Error {}

export class Contents {
  readonly head: Head;
  private readonly places = new Map<string, number>();
  private readonly decoded = new Map<number, Promise<Row[]>>();
  private firstRows?: Int32Array;
  private starts?: Int32Array;

  constructor() {
    const head = document.getElementById('contents');
    if (!head) throw new Fault('This page has no result in it. Write it again with viewpeel report.');
    if (!document.getElementById('end'))
      throw new Fault('This page is cut off: its end is missing. Copy it again, or write it again with viewpeel report.');
    try {
      this.head = JSON.parse(head.textContent ?? '') as Head;
    } catch {
      throw new Fault('This page is damaged: its list of contents cannot be read. Write it again with viewpeel report.');
    }
    if (this.head.format !== 1) throw new Fault(`This page has contents of format ${this.head.format}, and shows format 1.`);
    this.head.arrays.forEach((array, k) => this.places.set(array.name, k));
    this.head.arrays.forEach((array, k) => {
      if (!document.getElementById(`block-${k}`))
        throw new Fault(`This page is damaged: its part '${array.name}' is missing. Write it again with viewpeel report.`);
    });
  }

  has(name: string): boolean {
    return this.places.has(name);
  }

  async array(name: string): Promise<Values> {
    const place = this.places.get(name);
    if (place === undefined) throw new Fault(`This page has no part '${name}'.`);
    const { type, count } = this.head.arrays[place];
    const kind = TYPES[type];
    const bytes = await inflate(document.getElementById(`block-${place}`)?.textContent ?? '', name);
    if (bytes.length !== count * kind.BYTES_PER_ELEMENT) throw damaged(name);
    return new kind(unshuffle(bytes, kind.BYTES_PER_ELEMENT).buffer);
  }

  async integers(name: string): Promise<Int32Array> {
    return (await this.array(name)) as Int32Array;
  }

  async texts(name: string): Promise<string[]> {
    const bytes = await this.array(name);
    const texts = new TextDecoder().decode(bytes as Bytes).split('\0');
    texts.pop(); // the text after the last separator is empty
    return texts;
  }

  // Reads the tables that locate a row's entries: the first row of each block, and the number of each row's first entry.
  async open(): Promise<void> {
    this.firstRows = await this.integers('first_row');
    this.starts = await this.integers('start');
  }

  async row(row: number): Promise<Row> {
    if (!this.firstRows) throw new Error('open() comes first');
    let block = 0;
    for (let end = this.firstRows.length - 1; end - block > 1;) {
      const half = (block + end) >> 1;
      if (this.firstRows[half] <= row) block = half;
      else end = half;
    }
    let rows = this.decoded.get(block);
    if (!rows) {
      rows = this.decodeBlock(block);
      this.decoded.set(block, rows);
      if (this.decoded.size > 64) this.decoded.delete(this.decoded.keys().next().value as number);
    }
    return (await rows)[row - this.firstRows[block]];
  }

  private async decodeBlock(block: number): Promise<Row[]> {
    const part = (name: string) => (this.head.has_intervals || (name !== 'lower' && name !== 'upper') ? this.array(`${name}.${block}`) : undefined);
    const [steps, formFactor, standardError, lower, upper] =
      await Promise.all([this.array(`to.${block}`), this.array(`form_factor.${block}`), this.array(`standard_error.${block}`), part('lower'), part('upper')]);
    const starts = this.starts as Int32Array, firstRows = this.firstRows as Int32Array;
    const rows: Row[] = [], origin = starts[firstRows[block]];
    let at = 0;
    for (let row = firstRows[block]; row < firstRows[block + 1]; ++row) {
      const first = starts[row] - origin, end = starts[row + 1] - origin;
      const to = new Int32Array(end - first);
      for (let k = 0, column = 0; k < to.length; ++k) {
        let step = 0, shift = 0, byte;
        do {
          byte = steps[at++];
          step |= (byte & 127) << shift;
          shift += 7;
        } while (byte & 128);
        column += step;
        to[k] = column;
      }
      rows.push({
        to,
        formFactor: formFactor.subarray(first, end),
        standardError: standardError.subarray(first, end),
        lower: lower?.subarray(first, end),
        upper: upper?.subarray(first, end),
      });
    }
    return rows;
  }
}

function damaged(name: string): Fault {
  return new Fault(`This page is damaged in its part '${name}'. Copy it again, or write it again with viewpeel report.`);
}

// Inflates zlib's format; the browser verifies its check sum.
async function inflate(base64: string, name: string): Promise<Bytes> {
  try {
    const digits = atob(base64);
    const deflated = new Uint8Array(digits.length);
    for (let k = 0; k < digits.length; ++k) deflated[k] = digits.charCodeAt(k);
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  } catch {
    throw damaged(name);
  }
}

// Restores the order of bytes: the packed array has the first bytes of all values, then all second bytes, and so on.
function unshuffle(shuffled: Bytes, width: number): Bytes {
  if (width === 1) return shuffled;
  const count = shuffled.length / width;
  const bytes = new Uint8Array(shuffled.length);
  for (let byte = 0; byte < width; ++byte)
    for (let k = 0, from = byte * count, to = byte; k < count; ++k, to += width) bytes[to] = shuffled[from + k];
  return bytes;
}
