// This file draws charts: bars in SVG, and the picture of the matrix on a canvas.
import { css, Scale } from './colours';
import { asError, counted, element, inDigits, inThousands } from './format';

const SVG = 'http://www.w3.org/2000/svg';
const WIDTH = 360, HEIGHT = 170, LEFT = 8, BOTTOM = 26, TOP = 22, TICK_WIDTH = 38;

function shape(tag: string, attributes: Record<string, string | number>, text = ''): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.textContent = text;
  return made;
}

export interface Bars {
  title: string;
  first: number; // where bin 0 begins
  step: number;
  counts: number[];
  noun: string; // noun for what bars count
  tick(at: number): string | undefined; // text under the axis at this value, if any
  marks: { at: number; text: string }[];
}

// Draws a histogram. Heights are square roots of counts, so that small counts show beside large ones.
export function drawBars({ title, first, step, counts, noun, tick, marks }: Bars): HTMLElement {
  const svg = document.createElementNS(SVG, 'svg');
  svg.setAttribute('viewBox', `0 0 ${WIDTH} ${HEIGHT}`);
  svg.setAttribute('role', 'img');
  const most = Math.max(1, ...counts);
  const ends = [first, first + counts.length * step, ...marks.map(({ at }) => at)];
  const from = Math.min(...ends), to = Math.max(...ends);
  const across = (at: number) => LEFT + ((at - from) / (to - from || 1)) * (WIDTH - 2 * LEFT);
  const height = HEIGHT - BOTTOM - TOP;
  const width = across(from + step) - across(from);
  counts.forEach((count, k) => {
    if (count === 0) return;
    const high = Math.max(1, Math.sqrt(count / most) * height);
    const bar = shape('rect', { class: 'bar', x: across(first + k * step) + 0.5, y: HEIGHT - BOTTOM - high, width: Math.max(1, width - 1), height: high });
    bar.append(shape('title', {}, `${asBin(first + k * step)} to ${asBin(first + (k + 1) * step)}: ${counted(count, noun)}`));
    svg.append(bar);
  });
  svg.append(shape('line', { class: 'axis', x1: LEFT, x2: WIDTH - LEFT, y1: HEIGHT - BOTTOM, y2: HEIGHT - BOTTOM }));
  const ticks: { at: number; text: string }[] = [];
  for (let at = Math.ceil(from / step - 1e-9) * step; at <= to + step / 2; at += step) {
    const text = tick(at);
    if (text !== undefined) ticks.push({ at, text });
  }
  // Texts must not overlap: where there is no room for all, every second or third is shown.
  const every = ticks.length < 2 ? 1 : Math.ceil(TICK_WIDTH / (across(ticks[1].at) - across(ticks[0].at)));
  for (const { at, text } of ticks.filter((_, k) => (ticks.length - 1 - k) % every === 0)) {
    svg.append(shape('line', { class: 'axis', x1: across(at), x2: across(at), y1: HEIGHT - BOTTOM, y2: HEIGHT - BOTTOM + 4 }));
    const place = Math.min(WIDTH - 22, Math.max(22, across(at)));
    svg.append(shape('text', { class: 'tick', x: place, y: HEIGHT - BOTTOM + 17, 'text-anchor': 'middle' }, text));
  }
  for (const { at, text } of marks) {
    svg.append(shape('line', { class: 'mark', x1: across(at), x2: across(at), y1: TOP - 4, y2: HEIGHT - BOTTOM }));
    const isRight = across(at) > WIDTH * 0.6;
    svg.append(shape('text', { class: 'mark-text', x: across(at) + (isRight ? -4 : 4), y: TOP - 8, 'text-anchor': isRight ? 'end' : 'start' }, text));
  }
  const total = counts.reduce((sum, count) => sum + count, 0);
  svg.setAttribute('aria-label', `${title}: ${counted(total, noun)} from ${asBin(first)} to ${asBin(first + counts.length * step)}${marks.map(({ text }) => `; ${text}`).join('')}`);
  return element('figure', { class: 'chart' }, element('figcaption', {}, title), svg);

  function asBin(at: number): string {
    return tick === powerOfTen ? asError(10 ** at) : inDigits(at, 3);
  }
}

export function powerOfTen(at: number): string | undefined {
  return Math.abs(at - Math.round(at)) < 1e-6 ? `1e${Math.round(at)}` : undefined;
}

// Draws the picture of the matrix. Rows are in the order in which they lie in the scene.
//   In: values: size x size; each is the largest form factor of its cell
export function drawPicture(values: Float32Array, size: number, describe: (down: number, across: number) => string, choose: (down: number) => void): HTMLElement {
  const canvas = element('canvas', { width: String(size), height: String(size), class: 'picture', role: 'img' });
  const scale = Scale.of('logarithmic', values);
  const context = canvas.getContext('2d') as CanvasRenderingContext2D;
  const image = context.createImageData(size, size);
  let filled = 0;
  for (let k = 0; k < values.length; ++k) {
    if (values[k] <= 0) continue;
    ++filled;
    const colour = scale.colour(values[k]);
    image.data.set([colour[0], colour[1], colour[2], 255], 4 * k);
  }
  context.putImageData(image, 0, 0);
  canvas.setAttribute('aria-label', `Picture of the matrix, ${size} by ${size}: ${inThousands(filled)} of ${inThousands(size * size)} cells have a form factor`);
  const said = element('p', { class: 'said' }, 'Point at a cell.');
  const cellOf = (event: PointerEvent) => {
    const box = canvas.getBoundingClientRect();
    const place = (share: number) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
    return [place((event.clientY - box.top) / box.height), place((event.clientX - box.left) / box.width)] as const;
  };
  canvas.addEventListener('pointermove', (event) => (said.textContent = describe(...cellOf(event))));
  canvas.addEventListener('click', (event) => choose(cellOf(event as PointerEvent)[0]));
  const key = element('p', { class: 'key' }, `${inDigits(scale.least, 2)} `);
  const bar = element('span', { class: 'ramp' });
  bar.style.background = gradient(scale);
  key.append(bar, ` ${inDigits(scale.greatest, 3)}; blank: 0 or none`);
  return element('figure', { class: 'chart' }, element('figcaption', {}, 'Row down, column across; rows in the order of their places'), canvas, key, said);
}

export function gradient(scale: Scale): string {
  return `linear-gradient(to right, ${Array.from({ length: 17 }, (_, k) => css(scale.at(k / 16))).join(', ')})`;
}
