// These tests compare a page's panels with the run's files: errors, closure, matrix, run; for estimates and intervals.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { launch, makeFolder, openPage, parseCsv, program, readCsv, scene, viewpeel } from './browser.mjs';

const folder = makeFolder();
const NOT_PAIRS = ['environment', 'leak'];
// One run has standard errors, by polygon; the other has intervals, by surface.
const runs = {
  estimate: ['compute', scene('office.obj'), '--tolerance', '3e-2', '--promise', 'off', '--quiet'],
  guarantee: ['compute', scene('office.obj'), '--by', 'surface', '--epsilon', '1e-2', '--quiet'],
};
let browser;

before(async () => {
  for (const [name, words] of Object.entries(runs)) viewpeel(...words, '-o', folder.path(`${name}.csv`), '-o', folder.path(`${name}.html`));
  browser = await launch();
});
after(async () => {
  await browser?.close();
  folder.remove();
});

const open = (name, options) => openPage(browser, folder.path(`${name}.html`), options);
// Returns the entries of a run's .csv as objects, with keys from the header; environment and leak are included.
function entriesOf(name) {
  const [head, ...lines] = readCsv(folder.path(`${name}.csv`));
  return lines.map((line) => Object.fromEntries(head.map((key, k) => [key, k < 2 ? line[k] : Number(line[k])])));
}
const pairsOf = (name) => entriesOf(name).filter(({ to }) => !NOT_PAIRS.includes(to));
// Returns the bars of a histogram: first and last value, and count.
const barsOf = (chart) => chart.locator('rect.bar title').evaluateAll((titles) => titles.map(({ textContent }) => {
  const [, from, to, count] = textContent.match(/^(\S+) to (\S+): ([\d,]+) /);
  return { from: Number(from), to: Number(to), count: Number(count.replaceAll(',', '')) };
}));
const boundOf = ({ form_factor: f, lower, upper }) => Math.max(f - lower, upper - f);

for (const [name, errorOf, noun, goal] of [['estimate', (entry) => entry.standard_error, 'standard error', 0.03], ['guarantee', boundOf, 'error bound', 0.01]])
  test(`errors of the ${name}: a histogram against the goal`, async () => {
    const page = await open(name), panel = await page.panel('Errors');
    const pairs = pairsOf(name), errors = pairs.map(errorOf);
    const chart = panel.locator('figure.chart').first();
    assert.match(await chart.locator('figcaption').textContent(), new RegExp(noun));
    // Bars are a quarter of a power of ten wide. Their ends are written with two digits.
    const expected = new Map();
    for (const error of errors) if (error > 0) expected.set(Math.floor(4 * Math.log10(error)), (expected.get(Math.floor(4 * Math.log10(error))) ?? 0) + 1);
    const bars = await barsOf(chart);
    assert.deepEqual(bars.map(({ count }) => count), [...expected].sort(([a], [b]) => a - b).map(([, count]) => count));
    bars.forEach(({ from }, k) => assert.equal(from, Number((10 ** ([...expected.keys()].sort((a, b) => a - b)[k] / 4)).toExponential(1))));
    assert.equal(await chart.locator('.mark-text').textContent(), `goal ${goal}`);
    // The goal's line lies between the bars of smaller errors and the bars of larger ones, as the axis says.
    const line = Number(await chart.locator('line.mark').getAttribute('x1'));
    const lefts = await chart.locator('rect.bar').evaluateAll((rects) => rects.map((rect) => Number(rect.getAttribute('x'))));
    bars.forEach(({ from, to }, k) => assert.ok(to <= goal * 1.05 ? lefts[k] < line : from >= goal * 1.05 ? lefts[k] > line : true, `bar at ${from}`));

    const largest = errors.reduce((most, error) => Math.max(most, error), 0), facts = await panel.locator('dl.facts').first().textContent();
    assert.ok(facts.includes(`Largest${largest.toExponential(1)}`), facts);
    assert.ok(facts.includes(`Root mean square${Math.sqrt(errors.reduce((sum, error) => sum + error * error, 0) / errors.length).toExponential(1)}`), facts);
    if (name === 'guarantee') assert.ok(largest <= goal);

    // The table of the largest errors, copied as CSV, has the file's numbers, the largest first.
    await panel.getByRole('button', { name: 'Copy as CSV' }).last().click();
    const [head, ...lines] = parseCsv(await page.clipboard());
    // A page does not mark guesses, as the .csv does.
    const fileHead = readCsv(folder.path(`${name}.csv`))[0].filter((column) => column !== 'is_guess');
    assert.deepEqual(head, name === 'guarantee' ? [...fileHead, 'error_bound'] : fileHead);
    assert.equal(lines.length, Math.min(200, pairs.length));
    const sorted = [...errors].sort((a, b) => b - a), of = new Map(pairs.map((pair) => [`${pair.from} ${pair.to}`, pair]));
    lines.forEach((line, k) => {
      const pair = of.get(`${line[0]} ${line[1]}`);
      assert.equal(errorOf(pair), sorted[k]);
      assert.deepEqual(line.slice(2, fileHead.length).map(Number), fileHead.slice(2).map((key) => pair[key]));
      if (name === 'guarantee') assert.equal(Number(line.at(-1)), boundOf(pair));
    });
    await page.close();
  });

test('closure has the row sums of the file', async () => {
  const page = await open('estimate'), panel = await page.panel('Errors');
  const sums = new Map();
  for (const { from, form_factor: f } of entriesOf('estimate')) sums.set(from, (sums.get(from) ?? 0) + f);
  const chart = panel.locator('figure.chart').nth(1);
  assert.equal((await barsOf(chart)).reduce((sum, { count }) => sum + count, 0), sums.size);
  await panel.getByRole('button', { name: 'Copy as CSV' }).first().click();
  const [head, ...lines] = parseCsv(await page.clipboard());
  assert.deepEqual(head, ['row', 'row_sum_less_1', 'standard_error']);
  const distances = [...sums.values()].map((sum) => Math.abs(sum - 1)).sort((a, b) => b - a);
  assert.equal(lines.length, 100);
  // Sums of up to 578 numbers below 1 are in another order: each addition rounds by at most 2^-53.
  const rounding = 578 * 2 ** -53;
  lines.forEach(([row, off], k) => {
    assert.ok(Math.abs(Number(off) - (sums.get(row) - 1)) <= rounding, row);
    assert.ok(Math.abs(Math.abs(Number(off)) - distances[k]) <= rounding, row);
  });
  await page.close();
});

test('the matrix is drawn in the order of places, and each cell has its form factor', async () => {
  const page = await open('guarantee'), panel = await page.panel('Matrix');
  const picture = panel.locator('canvas.picture'), names = await page.tab.evaluate(() => window.viewpeelPage.rows.names);
  const of = new Map(pairsOf('guarantee').filter((pair) => pair.form_factor > 0).map((pair) => [`${pair.from} to ${pair.to}`, pair.form_factor]));
  const filled = await picture.evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return Array.from({ length: data.length / 4 }, (_, k) => data[4 * k + 3] > 0);
  });
  assert.equal(filled.length, names.length ** 2);
  assert.ok(filled.some((is) => is) && filled.some((is) => !is));
  const box = await picture.boundingBox(), size = names.length, rowNames = new Set();
  for (let down = 0; down < size; ++down)
    for (let across = 0; across < size; across += 1 + (down % 3)) {
      await page.tab.mouse.move(box.x + ((across + 0.5) / size) * box.width, box.y + ((down + 0.5) / size) * box.height);
      const [, pair, value] = (await panel.locator('.said').textContent()).match(/^(.+): (.+)$/);
      rowNames.add(pair.split(' to ')[0]);
      assert.equal(value === '0 or none', !of.has(pair), pair);
      assert.equal(filled[down * size + across], of.has(pair), pair);
      // The picture's values are floats, shown with four digits.
      if (of.has(pair)) assert.ok(Math.abs(Number(value) / of.get(pair) - 1) <= 5e-4 + 2 ** -24, `${pair}: ${value}`);
    }
  assert.deepEqual([...rowNames].sort(), [...names].sort());
  await picture.click({ position: { x: box.width / 2, y: (0.5 / size) * box.height } });
  await page.tab.waitForFunction((name) => document.querySelector('#panel-0 h2').textContent === `From ${name}`, [...rowNames][0]);
  await page.close();
});

test('the command of the run makes the same file', async () => {
  const page = await open('guarantee'), panel = await page.panel('Run');
  await panel.getByRole('button', { name: 'Copy' }).click();
  const command = await page.clipboard();
  assert.equal(command, ['viewpeel', ...runs.guarantee, '-o', folder.path('guarantee.csv'), '-o', folder.path('guarantee.html')].join(' '));
  const csv = readFileSync(folder.path('guarantee.csv'), 'utf8'), html = readFileSync(folder.path('guarantee.html'), 'utf8');
  execFileSync('sh', ['-c', command.replace(/^viewpeel/, `'${program}'`)], { stdio: 'ignore' });
  assert.equal(readFileSync(folder.path('guarantee.csv'), 'utf8'), csv);
  assert.ok(readFileSync(folder.path('guarantee.html'), 'utf8') === html);
  const parameters = new Map(await panel.locator('table.parameters tr').evaluateAll((rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent))));
  for (const [name, value] of [['epsilon', '0.01'], ['delta', '0.01'], ['seed', '1'], ['by', 'surface'], ['scene_file', 'office.obj']]) assert.equal(parameters.get(name), value, name);
  await page.close();
});

test('intervals are in tables, tips and colours', async () => {
  const page = await open('guarantee', { width: 1600, height: 900 });
  await page.tab.evaluate(() => window.viewpeelPage.chooseName('floor'));
  await (await page.panel('Selection')).getByRole('button', { name: 'Copy as CSV' }).click();
  const [head, ...lines] = parseCsv(await page.clipboard()), fileHead = readCsv(folder.path('guarantee.csv'))[0];
  assert.deepEqual(head, fileHead.slice(1));
  const row = new Map(pairsOf('guarantee').filter(({ from }) => from === 'floor').map((pair) => [pair.to, pair]));
  assert.equal(lines.length, row.size);
  for (const [to, ...numbers] of lines) assert.deepEqual(numbers.map(Number), fileHead.slice(2).map((key) => row.get(to)[key]), to);

  const place = await page.placeOf('desk');
  await page.tab.mouse.move(place.x, place.y);
  const { form_factor: f, lower, upper } = row.get('desk'), six = (value) => String(Number(value.toPrecision(6)));
  await page.tab.waitForFunction((text) => document.getElementById('tip').textContent.includes(text), `F from floor: ${six(f)}, in [${six(lower)}, ${six(upper)}]`);
  await page.tab.mouse.move(1590, 890);
  const colours = await page.colours();
  await page.tab.locator('#quantity').selectOption('error_bound');
  assert.notDeepEqual(await page.colours(), colours);
  assert.equal(await page.tab.locator('#legend-title').textContent(), 'Error bound from floor (no unit)');
  assert.match(await page.tab.locator('#facts').textContent(), /largest error bound/);
  await page.close();
});

// A telephone is 390 points wide. The table of the largest form factors has the most columns that a reader needs.
test('tables of intervals fit a telephone', async () => {
  const page = await open('guarantee', { width: 390, height: 844 });
  for (const name of ['Selection', 'Largest', 'Surfaces']) {
    const table = (await page.panel(name)).locator('.scroll').first();
    const { all, shown } = await table.evaluate(({ scrollWidth, clientWidth }) => ({ all: scrollWidth, shown: clientWidth }));
    assert.ok(shown > 300 && all <= shown, `${name}: ${all} of ${shown}`);
  }
  await page.close();
});
