// These tests check a page of 20,000 polygons and 4 million form factors: its size, time to load, frames per second, and numbers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { statSync } from 'node:fs';
import { test } from 'node:test';
import { cpuSeconds, launch, makeFolder, openPage, readCsv } from './browser.mjs';

test('a large page loads, turns, and has the numbers that were written', async () => {
  const folder = makeFolder(), file = folder.path('large.html'), row = folder.path('row.csv');
  process.stdout.write(execFileSync(process.env.VIEWPEEL_LARGE_PAGE, [file, row], { encoding: 'utf8' }));
  const size = statSync(file).size;
  assert.ok(size <= 60e6, `${size} bytes`);
  const browser = await launch();
  try {
    const cpuBefore = cpuSeconds(), before = performance.now();
    const page = await openPage(browser, file, { width: 1600, height: 900 });
    const seconds = (performance.now() - before) / 1000, cpu = cpuSeconds() - cpuBefore;
    console.log(`${(size / 1e6).toFixed(1)} MB; loaded in ${seconds.toFixed(2)} s, ${cpu.toFixed(2)} CPU s`);

    // Turns the scene for two seconds; each step draws a frame.
    const cpuTurning = cpuSeconds();
    const turned = await page.tab.evaluate(async () => {
      const { scene } = window.viewpeelPage, frames = scene.frames, begin = performance.now();
      while (performance.now() - begin < 2000) {
        scene.turn(0.02, 0);
        await new Promise(requestAnimationFrame);
      }
      return { frames: scene.frames - frames, seconds: (performance.now() - begin) / 1000 };
    });
    const cpuOfFrame = (cpuSeconds() - cpuTurning) / turned.frames;
    console.log(`${(turned.frames / turned.seconds).toFixed(1)} frames a second, ${(1000 * cpuOfFrame).toFixed(0)} CPU ms a frame`);
    assert.ok(turned.frames > 0);

    const expected = readCsv(row);
    const largest = await page.panel('Largest');
    await largest.getByRole('searchbox').fill('no such name');
    assert.equal(await largest.locator('tbody tr').count(), 0);
    const selection = await page.panel('Selection');
    await page.tab.evaluate((name) => window.viewpeelPage.chooseName(name), expected[0][0]);
    await page.tab.waitForFunction((name) => document.querySelector('#panel-0 h2').textContent === `From ${name}`, expected[0][0]);
    await selection.getByRole('button', { name: 'Copy as CSV' }).click();
    const shown = new Map((await page.clipboard()).trim().split('\n').slice(1).map((line) => line.split(',')).map(([to, f, error]) => [to, [Number(f), Number(error)]]));
    assert.equal(shown.size, expected.length);
    for (const [, to, f, error] of expected) {
      // This page has single-precision numbers, as its warning says.
      assert.equal(shown.get(to)[0], Math.fround(Number(f)), to);
      assert.equal(shown.get(to)[1], Math.fround(Number(error)), to);
    }
    assert.match(await page.tab.locator('#warning').textContent(), /rounded to 7 digits/);
    await page.close();
  } finally {
    await browser.close();
    folder.remove();
  }
});
