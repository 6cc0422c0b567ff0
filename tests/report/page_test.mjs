// These tests check the page of a result in Debian's Chromium: clicks, colours, numbers, keys, damaged pages. The
// browser must print nothing.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch, makeFolder, openPage, pictures, readCsv, scene, viewpeel, viewpeelFails } from './browser.mjs';

const folder = makeFolder();
const polygons = folder.path('office.html'), surfaces = folder.path('heat.html'), hostile = folder.path('hostile.html');
const HOSTILE = `</script><script>alert(1)</script><img/src=x/onerror=alert(2)>`;
let browser;

before(async () => {
  viewpeel('compute', scene('office.obj'), '--tolerance', '3e-2', '--promise', 'off', '--quiet', '-o', folder.path('office.h5'), '-o', folder.path('office.csv'));
  viewpeel('report', folder.path('office.h5'), '-o', polygons);
  viewpeel('solve', scene('office.obj'), '--materials', scene('office_materials.csv'), '--quiet', '-o', surfaces, '-o', folder.path('heat.csv'));
  // The floor of this room looks down, and names contain markup.
  const room = readFileSync(scene('cube.obj'), 'utf8').replace(/^o .*/m, `o ${HOSTILE}`);
  writeFileSync(folder.path('hostile.obj'), room);
  viewpeel('compute', folder.path('hostile.obj'), '--tolerance', '1e-2', '--flip', HOSTILE, '--quiet', '-o', hostile);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  folder.remove();
});

test('a click selects, and all other colours change', async () => {
  const page = await openPage(browser, polygons, { width: 1600, height: 900 });
  const first = await page.selected(), colours = await page.colours();
  const place = await page.placeOf('desk[1]') ?? await page.placeOf('floor[40]');
  assert.ok(place, 'neither is in sight');
  await page.tab.mouse.click(place.x, place.y);
  await page.tab.waitForFunction((text) => document.querySelector('#panel-0 h2').textContent !== text, first);
  const changed = (await page.colours()).filter((colour, k) => colour !== colours[k]).length;
  assert.ok(changed > 0.2 * colours.length, `${changed} of ${colours.length} places have another colour`);
  await page.tab.mouse.move(place.x + 1, place.y);
  await page.tab.waitForFunction(() => /F from (desk\[1\]|floor\[40\]): .*area /.test(document.getElementById('tip').textContent));
  // Negative control: an action that does not change the scene changes no colour.
  await page.tab.mouse.move(1500, 20);
  const before = await page.colours();
  await page.panel('Run');
  assert.deepEqual(await page.colours(), before);
  await page.close();
});

test('numbers are the file\'s, to the last bit', async () => {
  const page = await openPage(browser, polygons);
  const from = 'desk[1]';
  const expected = readCsv(folder.path('office.csv')).filter(([name, to]) => name === from && to !== 'environment' && to !== 'leak');
  assert.ok(expected.length > 100);
  await page.tab.evaluate((name) => window.viewpeelPage.chooseName(name), from);
  await (await page.panel('Selection')).getByRole('button', { name: 'Copy as CSV' }).click();
  const shown = new Map((await page.clipboard()).trim().split('\n').slice(1).map((line) => line.split(',')).map(([to, ...numbers]) => [to, numbers.map(Number)]));
  assert.equal(shown.size, expected.length);
  for (const [, to, f, error] of expected) assert.deepEqual(shown.get(to), [Number(f), Number(error)], to);

  // A single row, and the first lines of the table of largest form factors, have the file's numbers.
  const all = readCsv(folder.path('office.csv')).slice(1).filter(([, to]) => to !== 'environment' && to !== 'leak');
  const largest = all.reduce((most, [, , f]) => Math.max(most, Number(f)), 0);
  await (await page.panel('Largest')).getByRole('button', { name: 'Copy this row as CSV' }).first().click();
  assert.equal(Number((await page.clipboard()).trim().split('\n')[1].split(',')[2]), largest);
  await page.close();
});

test('tables are sorted and searched', async () => {
  const page = await openPage(browser, polygons);
  const panel = await page.panel('Largest');
  await panel.getByRole('searchbox').fill('desk lamp');
  const lines = await panel.locator('tbody tr').allTextContents();
  assert.ok(lines.length > 0 && lines.every((line) => line.includes('desk') && line.includes('lamp')));
  await panel.getByRole('searchbox').fill('');
  const numbers = async () => (await panel.locator('tbody tr td:nth-child(3)').evaluateAll((cells) => cells.map((cell) => Number(cell.title))));
  const isFalling = (values) => values.every((value, k) => k === 0 || value <= values[k - 1]);
  assert.ok(isFalling(await numbers()));
  await panel.getByRole('button', { name: 'Form factor' }).click();
  assert.ok(!isFalling(await numbers()) && isFalling((await numbers()).reverse()));
  await page.close();
});

test('heat is there, and keys do what the mouse does', async () => {
  const page = await openPage(browser, surfaces, { colorScheme: 'dark' });
  const radiator = readCsv(folder.path('heat.csv')).find(([name]) => name === 'radiator');
  await page.tab.evaluate(() => window.viewpeelPage.chooseName('radiator'));
  const facts = await page.tab.locator('#panel-0 .facts').textContent();
  assert.ok(facts.includes(`${Number(radiator[3])} K`), facts);
  const temperature = await page.colours();
  await page.tab.locator('#quantity').selectOption('heat_flux');
  assert.notDeepEqual(await page.colours(), temperature);
  assert.match(await page.tab.locator('#legend-title').textContent(), /Net heat flux, W\/m²/);

  await page.tab.locator('#scene').focus();
  const still = await page.colours(), name = await page.selected();
  await page.tab.keyboard.press('ArrowLeft');
  assert.notDeepEqual(await page.colours(), still);
  await page.tab.keyboard.press('n');
  await page.tab.waitForFunction((text) => document.querySelector('#panel-0 h2').textContent !== text, name);
  await page.tab.getByRole('tab', { name: 'Selection' }).focus();
  await page.tab.keyboard.press('ArrowRight');
  assert.equal(await page.tab.getByRole('tab', { name: 'Largest' }).getAttribute('aria-selected'), 'true');
  // Every control has a name for screen readers.
  const nameless = await page.tab.evaluate(() => [...document.querySelectorAll('button, select, input, canvas, svg')]
    .filter((part) => !(part.getAttribute('aria-label') || part.textContent.trim() || part.labels?.length)).map((part) => part.outerHTML));
  assert.deepEqual(nameless, []);
  await page.close();
});

test('names are text, and surfaces that leak come first', async () => {
  assert.ok(!readFileSync(hostile, 'utf8').includes('alert('));
  const page = await openPage(browser, hostile);
  assert.equal(await page.tab.locator('#backs').inputValue(), 'hatched');
  const panel = await page.panel('Surfaces');
  const leaks = await panel.locator('tbody tr td:nth-child(2)').evaluateAll((cells) => cells.map((cell) => Number(cell.title)));
  assert.ok(leaks[0] > 0.1 && leaks.every((leak, k) => k === 0 || leak <= leaks[k - 1]), String(leaks));
  assert.ok((await panel.locator('tbody').textContent()).includes(HOSTILE));
  await page.close();
});

test('a flipped surface is seen at once', async () => {
  const PINK = [0xd6, 0x33, 0x6c]; // backs, in page/palette.json
  viewpeel('compute', scene('office.obj'), '--by', 'surface', '--tolerance', '3e-2', '--flip', 'desk', '--quiet', '-o', folder.path('flipped.html'));
  const flipped = await openPage(browser, folder.path('flipped.html'));
  assert.ok(await flipped.hasBlock(PINK, 8));
  await flipped.tab.locator('#backs').selectOption('dotted');
  assert.ok(!(await flipped.hasBlock(PINK, 8)));
  await flipped.close();
  // In a correct scene, walls seen from behind are hatched by lines of two pixels.
  const whole = await openPage(browser, surfaces);
  await whole.tab.locator('#backs').selectOption('hatched');
  assert.ok((await whole.hasBlock(PINK, 1)) && !(await whole.hasBlock(PINK, 8)));
  await whole.close();
});

test('damage is said in a sentence', async () => {
  const whole = readFileSync(polygons, 'utf8');
  const middle = whole.indexOf('id="block-9"') + 40;
  const cases = [
    [whole.slice(0, whole.length * 0.7), /cut off/],
    [whole.slice(0, middle) + (whole[middle] === 'A' ? 'B' : 'A') + whole.slice(middle + 1), /damaged/],
    [whole.replace(/<script type="application\/json"[^]*?<\/script>/, ''), /no result/],
  ];
  for (const [text, sentence] of cases) {
    writeFileSync(folder.path('broken.html'), text);
    const page = await openPage(browser, folder.path('broken.html'));
    assert.match(await page.fault(), sentence);
    await page.close();
  }
  const file = readFileSync(folder.path('office.h5'));
  writeFileSync(folder.path('broken.h5'), file.subarray(0, file.length / 2));
  const { status, stderr } = viewpeelFails('report', folder.path('broken.h5'), '-o', folder.path('x.html'));
  assert.equal(status, 2);
  assert.match(stderr, /broken\.h5: not a whole result: .*cut off or damaged.*\n$/);
});

test('pictures at three widths', async () => {
  for (const [width, height, colorScheme, file] of [[390, 844, 'light', polygons], [1024, 768, 'dark', surfaces], [1600, 900, 'light', polygons]]) {
    const page = await openPage(browser, file, { width, height, colorScheme });
    await page.colours();
    await page.tab.screenshot({ path: join(pictures, `${width}-${colorScheme}.png`) });
    // Nothing is wider than the window. Tables fit their panels; on a telephone the table of errors scrolls.
    for (const name of ['Selection', 'Largest', 'Surfaces', 'Errors', 'Matrix', 'Run']) {
      await page.panel(name);
      const wide = await page.tab.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${name}: ${wide} pixels at ${width}`);
      const tables = await page.tab.locator('.scroll:visible').evaluateAll((all) => all.map((table) => [table.scrollWidth, table.clientWidth]));
      for (const [needs, has] of tables) assert.ok(needs <= has || (width < 400 && name === 'Errors'), `${name}: a table of ${needs} pixels in ${has} at ${width}`);
    }
    await page.close();
  }
});
