// A Table can be sorted by a click on a heading and searched by words.
import { asCsv, copy, counted, element } from './format';

export interface Column<T> {
  key: string; // name in a .csv
  title: string; // '' for a column that only a .csv has
  isNumber: boolean;
  value(item: T): string | number; // sorts rows, and is written to a .csv
  text(item: T): string;
  rank?(item: T): number; // sorts rows where value() does not
}

const PAGE = 200; // rows shown at once

// A Table shows items; a click on one chooses it.
export class Table<T> {
  readonly root: HTMLElement;
  private items: T[] = [];
  private shown = PAGE;
  private sorted = 0;
  private isDescending = false;
  private readonly search: HTMLInputElement;
  private readonly head = element('tr');
  private readonly body = element('tbody');
  private readonly count = element('p', { class: 'count', role: 'status' });
  private readonly more = element('button', { type: 'button', class: 'more' }, 'Show more');
  private readonly columns: Column<T>[]; // the columns that are shown

  constructor(
    private readonly all: Column<T>[], caption: string,
    private readonly options: { sorted: string; choose?: (item: T) => void; say: (text: string) => void },
  ) {
    const columns = (this.columns = all.filter(({ title }) => title !== ''));
    this.sorted = columns.findIndex(({ key }) => key === options.sorted);
    this.isDescending = columns[this.sorted].isNumber;
    this.search = element('input', { type: 'search', placeholder: 'Search names', 'aria-label': `Search: ${caption}` });
    const copyAll = element('button', { type: 'button', class: 'copy-all' }, 'Copy as CSV');
    copyAll.addEventListener('click', () => this.copyLines(this.matching(), 'the table'));
    this.more.addEventListener('click', () => {
      this.shown += PAGE;
      this.draw();
    });
    this.search.addEventListener('input', () => {
      this.shown = PAGE;
      this.draw();
    });
    columns.forEach((column, k) => {
      const button = element('button', { type: 'button' }, column.title);
      button.addEventListener('click', () => this.sortBy(k));
      this.head.append(element('th', { scope: 'col', class: column.isNumber ? 'number' : '' }, button));
    });
    this.head.append(element('th', { scope: 'col' }, element('span', { class: 'unseen' }, 'Copy')));
    const table = element('table', {}, element('caption', { class: 'unseen' }, caption), element('thead', {}, this.head), this.body);
    this.root = element('div', { class: 'table' }, element('div', { class: 'bar' }, this.search, copyAll), this.count, element('div', { class: 'scroll' }, table), this.more);
  }

  show(items: T[]): void {
    this.items = items;
    this.shown = PAGE;
    this.draw();
  }

  private sortBy(column: number): void {
    this.isDescending = column === this.sorted ? !this.isDescending : this.columns[column].isNumber;
    this.sorted = column;
    this.draw();
  }

  private matching(): T[] {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const names = this.columns.filter((column) => !column.isNumber);
    const matches = words.length
      ? this.items.filter((item) => {
          const text = names.map((column) => column.text(item)).join(' ').toLowerCase();
          return words.every((word) => text.includes(word));
        })
      : this.items.slice();
    const { isNumber, value, rank = value } = this.columns[this.sorted];
    const sign = this.isDescending ? -1 : 1;
    return matches.sort((a, b) => sign * (isNumber ? Number(rank(a)) - Number(rank(b)) : String(value(a)).localeCompare(String(value(b)), 'en', { numeric: true })));
  }

  private copyLines(items: T[], what: string): void {
    const lines = items.map((item) => this.all.map((column) => column.value(item)));
    void copy(asCsv([this.all.map(({ key }) => key), ...lines])).then((done) =>
      this.options.say(done ? `Copied ${what} as CSV.` : 'The browser does not allow copying here.'),
    );
  }

  private draw(): void {
    const matching = this.matching();
    [...this.head.children].forEach((cell, k) => {
      if (k < this.columns.length) cell.setAttribute('aria-sort', k !== this.sorted ? 'none' : this.isDescending ? 'descending' : 'ascending');
    });
    this.body.replaceChildren(...matching.slice(0, this.shown).map((item) => this.line(item)));
    this.more.hidden = matching.length <= this.shown;
    this.count.textContent = matching.length === this.items.length ? counted(matching.length, 'row') : `${counted(matching.length, 'row')} of ${this.items.length}`;
  }

  private line(item: T): HTMLTableRowElement {
    const line = element('tr');
    this.columns.forEach((column, k) => {
      const text = column.text(item);
      const cell = element('td', { class: column.isNumber ? 'number' : 'name', title: String(column.value(item)) });
      if (k === 0 && this.options.choose) {
        const button = element('button', { type: 'button', class: 'choose' }, text);
        button.addEventListener('click', () => this.options.choose?.(item));
        cell.append(button);
      } else cell.textContent = text;
      line.append(cell);
    });
    const button = element('button', { type: 'button', class: 'copy', 'aria-label': 'Copy this row as CSV', title: 'Copy this row as CSV' }, 'CSV');
    button.addEventListener('click', () => this.copyLines([item], 'the row'));
    line.append(element('td', {}, button));
    return line;
  }
}
