// These tests check a page of 20,000 polygons and 4.2 million form factors, and what pages of 6.8 million leave out.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { statSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { launch, makeFolder, openPage, parseCsv, readCsv, viewpeel } from './browser.mjs';

const MOST_BYTES = 60e6;
const folder = makeFolder();
let browser;

before(async () => (browser = await launch()));
after(async () => {
  await browser?.close();
  folder.remove();
});

const makeLarge = (...words) => execFileSync(process.env.VIEWPEEL_LARGE_PAGE, words, { encoding: 'utf8' });
// Writes a result and its page. Returns the number of form factors.
function makeReport(kind) {
  const count = Number(makeLarge(kind, folder.path('large.h5'), folder.path(`${kind}.csv`)));
  viewpeel('report', folder.path('large.h5'), '-o', folder.path(`${kind}.html`));
  const size = statSync(folder.path(`${kind}.html`)).size;
  assert.ok(size <= MOST_BYTES, `${size} bytes`);
  return count;
}
// Returns the form factors from a row as its panel copies them: numbers by the names of rows.
async function copyRow(page, name) {
  const selection = await page.panel('Selection');
  await page.tab.evaluate((row) => window.viewpeelPage.chooseName(row), name);
  await page.tab.waitForFunction((row) => document.querySelector('#panel-0 h2').textContent === `From ${row}`, name);
  await selection.getByRole('button', { name: 'Copy as CSV' }).click();
  const [head, ...lines] = parseCsv(await page.clipboard());
  return { head, row: new Map(lines.map(([to, ...numbers]) => [to, numbers.map(Number)])) };
}

test('a large page loads its rows on demand, and has the numbers that were written', async () => {
  const file = folder.path('page.html'), csv = folder.path('page.csv');
  makeLarge(file, csv);
  assert.ok(statSync(file).size <= MOST_BYTES);
  const page = await openPage(browser, file, { width: 1600, height: 900 });
  const decoded = () => page.tab.evaluate(() => window.viewpeelPage.contents.decoded.size);
  assert.equal(await decoded(), 1); // only the block of the row that is selected at first, of some hundred blocks
  const expected = readCsv(csv), { row } = await copyRow(page, expected[0][0]);
  assert.equal(await decoded(), 2);
  assert.equal(row.size, expected.length);
  // The page says that it has floats here.
  for (const [, to, f, error] of expected) assert.deepEqual(row.get(to), [Math.fround(Number(f)), Math.fround(Number(error))], to);
  assert.match(await page.tab.locator('#warning').textContent(), /rounded to 7 digits/);

  const width = () => page.tab.evaluate(() => document.getElementById('scene').width);
  const still = await width();
  // The scene turns while other work takes 60 ms of each frame. So it is drawn coarser, and sharp once it is still. The
  // width is read during the turns, for afterwards the scene may be still, and sharp, at any time.
  const coarsest = await page.tab.evaluate(async () => {
    let least = Infinity;
    for (let turn = 0; turn < 30; ++turn) {
      window.viewpeelPage.scene.turn(0.02, 0);
      for (const begin = performance.now(); performance.now() - begin < 60;);
      await new Promise(requestAnimationFrame);
      least = Math.min(least, document.getElementById('scene').width);
    }
    return least;
  });
  assert.ok(coarsest <= 0.31 * still, `${coarsest} of ${still} pixels`);
  await page.tab.waitForFunction((pixels) => document.getElementById('scene').width === pixels, still);
  await page.close();
});

test('form factors that do not fit are added up by surface', async () => {
  const count = makeReport('by-surface');
  const page = await openPage(browser, folder.path('by-surface.html'));
  assert.match(await page.tab.locator('#warning').textContent(),
    new RegExp(`^${count} form factors between 20000 rows do not fit a page\\. They are added up here, between 40 surfaces\\.`));
  const bySurface = new Map();
  for (const [from, to, ...numbers] of readCsv(folder.path('by-surface.csv'))) bySurface.set(from, [...(bySurface.get(from) ?? []), [to, numbers.map(Number)]]);
  assert.equal(bySurface.size, 40);
  // Sums of up to 500 x 500 products are in another order: each addition rounds by 2^-53.
  const rounding = 500 * 500 * 2 ** -53;
  for (const surface of ['field_0', 'field_17', 'field_39']) {
    const { head, row } = await copyRow(page, surface);
    assert.deepEqual(head, ['to', 'form_factor', 'standard_error_at_most', 'lower', 'upper']);
    const expected = bySurface.get(surface);
    assert.equal(row.size, expected.length);
    for (const [to, numbers] of expected)
      numbers.forEach((number, k) => assert.ok(Math.abs(row.get(to)[k] / number - 1) <= rounding, `${surface} to ${to}: ${row.get(to)} for ${numbers}`));
  }
  await page.close();
});

test('without fewer surfaces the smallest form factors are left out', async () => {
  const count = makeReport('by-size');
  const page = await openPage(browser, folder.path('by-size.html'));
  const [, left, all, cut, most] = (await page.tab.locator('#warning').textContent())
    .match(/^(\d+) of (\d+) form factors do not fit a page and are left out\. Each is below (\S+); in no row do they add up to more than (\S+?)\. /);
  assert.equal(Number(all), count);
  assert.ok(Number(left) > 0);
  const expected = readCsv(folder.path('by-size.csv')), { row } = await copyRow(page, expected[0][0]);
  // The page shows bounds with two digits, so they may be 5 % off.
  let sum = 0;
  for (const [, to, text] of expected) {
    const f = Number(text);
    if (row.has(to)) assert.equal(row.get(to)[0], Math.fround(f), to);
    else sum += f;
    assert.ok(row.has(to) ? f >= cut / 1.05 : f <= cut * 1.05, `${to}: ${f}`);
  }
  assert.ok(row.size < expected.length && row.size > 0);
  assert.ok(sum <= most * 1.05, `${sum} of ${most}`);
  await page.close();
});
