// These functions open pages in Debian's Chromium, without a display and with software GL. A page that prints or
// requests anything fails its test.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const { VIEWPEEL_PROGRAM: program, VIEWPEEL_PAGE: page, VIEWPEEL_SCENES: scenes } = process.env;
const { chromium } = createRequire(join(page, 'package.json'))('playwright-core');

export const pictures = join(page, 'pictures');
mkdirSync(pictures, { recursive: true });
export const scene = (name) => join(scenes, name);

export function makeFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'viewpeel-report-'));
  return { path: (name) => join(folder, name), remove: () => rmSync(folder, { recursive: true, force: true }) };
}

export const viewpeel = (...words) => execFileSync(program, words, { stdio: ['ignore', 'pipe', 'pipe'], encoding: 'utf8' });
// Returns status and standard error of a call that fails.
export const viewpeelFails = (...words) => {
  const { status, stderr } = spawnSync(program, words, { encoding: 'utf8' });
  return { status, stderr };
};

// Reads lines of CSV as `viewpeel compute -o` writes them; no name has a comma here.
export const readCsv = (file) => parseCsv(readFileSync(file, 'utf8'));
export const parseCsv = (text) => text.trim().split('\n').map((line) => line.split(','));

// Starts Chromium as on a machine without a GPU: SwiftShader draws WebGL, and the processor draws the rest of the page.
export const launch = (...more) => {
  const executablePath = '/usr/bin/chromium';
  assert.ok(existsSync(executablePath), `${executablePath} is missing: scripts/test installs it`);
  return chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-gpu', '--enable-unsafe-swiftshader', ...more] });
};

// Chromium prints a note of its own when it copies the scene from SwiftShader; it would for any page.
const isOwnNote = (text) => /GL Driver Message \(OpenGL, Performance, .*GPU stall due to ReadPixels/.test(text);

// Returns a page that is ready, or shows its fault.
export async function openPage(browser, file, { width = 1024, height = 768, colorScheme = 'light', clipboard = true } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme });
  if (clipboard) await context.grantPermissions(['clipboard-read', 'clipboard-write']);
  const tab = await context.newPage();
  const heard = [];
  tab.on('console', (message) => ['error', 'warning'].includes(message.type()) && !isOwnNote(message.text()) && heard.push(`console: ${message.text()}`));
  tab.on('pageerror', (error) => heard.push(`error: ${error.message}`));
  tab.on('request', (request) => /^(file|data|blob):/.test(request.url()) || heard.push(`request: ${request.url()}`));
  tab.on('dialog', (dialog) => heard.push(`dialog: ${dialog.message()}`));
  await tab.goto(`file://${file}`);
  await tab.waitForFunction(() => document.body.dataset.state === 'ready' || !document.getElementById('fault').hidden, undefined, { timeout: 60000 });
  return {
    tab, heard,
    fault: () => tab.locator('#fault').evaluate((fault) => (fault.hidden ? '' : fault.textContent)),
    selected: () => tab.locator('#panel-0 h2').textContent(),
    choose: (name) => tab.locator('#unit').selectOption(name),
    // Shows the panel of this tab and returns it.
    panel: async (name) => {
      await tab.getByRole('tab', { name }).click();
      return tab.getByRole('tabpanel', { name });
    },
    // Returns the colours of the scene on a grid of pixels.
    colours: async () => {
      await tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      const shot = await tab.locator('#scene').screenshot();
      return tab.evaluate(async (base64) => {
        const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (digit) => digit.charCodeAt(0))], { type: 'image/png' }));
        const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        const colours = [], { data } = context.getImageData(0, 0, image.width, image.height);
        for (let y = 10; y < image.height; y += 20)
          for (let x = 10; x < image.width; x += 20) colours.push(data.slice(4 * (y * image.width + x), 4 * (y * image.width + x) + 3).join(' '));
        return colours;
      }, shot.toString('base64'));
    },
    // Returns whether the scene has a square of pixels that are all of one colour.
    hasBlock: async (colour, size) => {
      await tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      const shot = await tab.locator('#scene').screenshot();
      return tab.evaluate(async ([base64, [red, green, blue], side]) => {
        const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (digit) => digit.charCodeAt(0))], { type: 'image/png' }));
        const { width, height } = image, context = new OffscreenCanvas(width, height).getContext('2d');
        context.drawImage(image, 0, 0);
        const { data } = context.getImageData(0, 0, width, height);
        const is = (x, y) => data[4 * (y * width + x)] === red && data[4 * (y * width + x) + 1] === green && data[4 * (y * width + x) + 2] === blue;
        for (let y = 0; y + side <= height; ++y)
          for (let x = 0; x + side <= width; ++x) {
            let at = 0;
            while (at < side * side && is(x + (at % side), y + Math.floor(at / side))) ++at;
            if (at === side * side) return true;
          }
        return false;
      }, [shot.toString('base64'), colour, size]);
    },
    // Returns a place in the window over a polygon of this row or surface, or null.
    placeOf: (name) => tab.evaluate((wanted) => {
      const box = document.getElementById('scene').getBoundingClientRect();
      for (let y = box.top + 5; y < box.bottom; y += 6)
        for (let x = box.left + 5; x < box.right; x += 6) {
          const under = document.elementFromPoint(x, y);
          if (under?.id === 'scene' && window.viewpeelPage.nameAt(x, y) === wanted) return { x, y };
        }
      return null;
    }, name),
    clipboard: () => tab.evaluate(() => navigator.clipboard.readText()),
    close: async () => {
      assert.deepEqual(heard, [], 'what the page printed or asked for');
      await context.close();
    },
  };
}

// Returns the CPU seconds of this process and of its children that still run, the browser's processes.
export function cpuSeconds() {
  const list = execFileSync('ps', ['-eo', 'pid=,ppid=,cputimes='], { encoding: 'utf8' }).trim().split('\n').map((line) => line.trim().split(/\s+/).map(Number));
  const family = new Set([process.pid]);
  for (let size = 0; size !== family.size;) {
    size = family.size;
    for (const [pid, parent] of list) if (family.has(parent)) family.add(pid);
  }
  const ticks = (pid) => {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').replace(/^.*\) /s, '').split(' ');
      return Number(fields[11]) + Number(fields[12]);
    } catch {
      return 0; // it has ended
    }
  };
  let sum = 0;
  for (const pid of family) sum += ticks(pid);
  return sum / 100;
}
