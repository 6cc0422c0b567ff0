#!/usr/bin/env node
// Measures how long a page of 20,000 polygons and 4.2 million form factors takes to load, and its frames a second.
//   bench/page.mjs [BUILD] [ROUNDS]      BUILD: a build with viewpeel_large_page, build/release by default
// It prints a line a round: seconds from the call until the page can be used, and CPU seconds of all of Chromium's
// processes meanwhile. Frames a second over two seconds, CPU milliseconds a frame, the pixels across and the machine's
// load follow. Chromium is Debian's. It runs without a display and without a GPU, so that SwiftShader computes WebGL.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('..', import.meta.url)), build = resolve(process.argv[2] ?? `${root}build/release`), rounds = Number(process.argv[3] ?? 5);
process.env.VIEWPEEL_PAGE = `${build}/page`;
const { cpuSeconds, launch, makeFolder, openPage } = await import(`${root}tests/report/browser.mjs`);

const folder = makeFolder(), file = folder.path('large.html');
process.stdout.write(execFileSync(`${build}/viewpeel_large_page`, [file, folder.path('row.csv')], { encoding: 'utf8' }));
console.log(`${cpus().length} x ${cpus()[0].model}`);
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
const loads = [], rates = [];
for (let round = 0; round < rounds; ++round) {
  const browser = await launch();
  const begin = performance.now(), cpuBefore = cpuSeconds();
  const page = await openPage(browser, file, { width: 1600, height: 900 });
  loads.push((performance.now() - begin) / 1000);
  const cpuOfLoad = cpuSeconds() - cpuBefore;
  const turn = (seconds) => page.tab.evaluate(async (limit) => {
    const { scene } = window.viewpeelPage, frames = scene.frames, start = performance.now();
    while (performance.now() - start < 1000 * limit) {
      scene.turn(0.02, 0);
      await new Promise(requestAnimationFrame);
    }
    return { frames: scene.frames - frames, seconds: (performance.now() - start) / 1000, across: document.getElementById('scene').width };
  }, seconds);
  await turn(0.5); // shaders are compiled at first
  const before = cpuSeconds(), { frames, seconds, across } = await turn(2), cpu = (cpuSeconds() - before) / frames;
  rates.push(frames / seconds);
  const load = readFileSync('/proc/loadavg', 'utf8').split(' ')[0];
  console.log(`loaded in ${loads.at(-1).toFixed(2)} s, ${cpuOfLoad.toFixed(2)} CPU s; ${rates.at(-1).toFixed(1)} frames a second, ${(1000 * cpu).toFixed(0)} CPU ms a frame, ${across} pixels across; load ${load}`);
  await browser.close();
}
console.log(`median: loaded in ${median(loads).toFixed(2)} s, ${median(rates).toFixed(1)} frames a second`);
folder.remove();
