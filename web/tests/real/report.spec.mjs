// The 3D view of a report that the program has made, opened from the disk as a reader does.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';
import { launch } from '../browser.mjs';
import { program } from './program.mjs';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const ANIMAL = 'type: quadruped, gait: gallop, resolution: 30, frames: 4';
const PIPELINE = `source: { generator: { ${ANIMAL}, proportions: horse } }
target: { generator: { ${ANIMAL}, proportions: camel, seed: 1 } }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
pictures: { view_3d: true }
output: [out/report.html]
`;

let browser;
let folder;
let url;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'mimesh-report-'));
  writeFileSync(join(folder, 'p.yaml'), PIPELINE);
  execFileSync(program, ['run', 'p.yaml', '--quiet', '--no-cache'], {
    cwd: folder,
    stdio: ['ignore', 'ignore', 'inherit'],
  });
  url = pathToFileURL(join(folder, 'out/report.html')).href;
  browser = await launch();
});

after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true });
});

/** The report at a width; `problems` gathers what the console complains of, and requests. */
async function open(width, options = {}) {
  const page = await (options.browser ?? browser).newPage({ viewport: { width, height: 844 }, ...options });
  page.problems = [];
  page.on('pageerror', (error) => page.problems.push(String(error)));
  page.on('console', (message) => page.problems.push(message.text()));
  page.on('request', (request) => {
    if (request.url() !== url && !request.url().startsWith('data:')) page.problems.push(request.url());
  });
  await page.goto(url);
  await page.locator('#view-3d').scrollIntoViewIfNeeded();
  return page;
}

/** Of each view, how much of it a mesh covers, and a number that changes with the picture. */
function look(page) {
  return page.evaluate(async () => {
    await new Promise((done) => setTimeout(done, 300));
    const { views } = window.mimesh.stage;
    const canvas = document.querySelector('#view-3d canvas');
    const bounds = canvas.getBoundingClientRect();
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext('2d', { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const ratio = canvas.width / bounds.width;
    return views.map(({ element }) => {
      const box = element.getBoundingClientRect();
      const place = [box.left - bounds.left, box.top - bounds.top, box.width, box.height];
      const { data } = context.getImageData(...place.map((length) => Math.round(length * ratio)));
      let [covered, sum] = [0, 0];
      for (let i = 0; i < data.length; i += 4) {
        const isMesh = data[i] !== data[0] || data[i + 1] !== data[1] || data[i + 2] !== data[2];
        if (isMesh) covered += 1;
        sum = (Math.imul(sum, 31) + data[i] + data[i + 1] * 3 + data[i + 2] * 7) | 0;
      }
      return { covered: covered / (data.length / 4), sum };
    });
  });
}

/** Which of both views show another picture than before. */
async function changed(page, act) {
  const earlier = await look(page);
  await act();
  const later = await look(page);
  return later.map(({ sum }, side) => sum !== earlier[side].sum);
}

async function drag(page, side, x, y) {
  const box = await page.locator('.v3-surface').nth(side).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + x, box.y + box.height / 2 + y, { steps: 4 });
  await page.mouse.up();
}

for (const width of [1200, 390]) {
  test(`at ${width} pixels both meshes are seen, and turn together`, async () => {
    const page = await open(width);
    for (const { covered } of await look(page)) assert.ok(covered > 0.08 && covered < 0.7, `${covered}`);
    assert.deepEqual(await changed(page, () => drag(page, 0, 80, 20)), [true, true]);
    assert.deepEqual(await changed(page, () => drag(page, 1, -30, 0)), [true, true]);
    assert.deepEqual(await changed(page, () => page.keyboard.press('ArrowLeft')), [true, true]);
    assert.deepEqual(await changed(page, () => page.keyboard.press('+')), [true, true]);
    assert.deepEqual(await changed(page, () => page.keyboard.press('Shift+ArrowUp')), [true, true]);
    const [source, result] = await page.evaluate(() =>
      window.mimesh.stage.views.map(({ orbit: { yaw, pitch, distance } }) => ({ yaw, pitch, distance })),
    );
    assert.deepEqual(source, result);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    assert.deepEqual(page.problems, []);
    await page.close();
  });
}

test('poses, colours, wireframe and rest are chosen', async () => {
  const page = await open(1200);
  const poses = page.getByRole('radio');
  assert.equal(await poses.count(), 4);
  assert.deepEqual(await changed(page, () => poses.nth(1).check()), [true, true]);
  assert.deepEqual(await changed(page, () => page.getByRole('checkbox', { name: 'Colours' }).uncheck()), [false, true]);
  assert.equal(await page.locator('.v3-legend').isVisible(), false);
  await page.getByRole('checkbox', { name: 'Colours' }).check();
  assert.match(await page.locator('.v3-legend').textContent(), /error, %.*0.*5/);
  assert.deepEqual(await changed(page, () => page.getByLabel('Wireframe').check()), [true, true]);
  assert.deepEqual(await changed(page, () => page.getByLabel('At rest').check()), [true, true]);
  const rest = await look(page);
  await poses.nth(2).check();
  assert.deepEqual(await look(page), rest);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('two fingers zoom, and one turns', async () => {
  const page = await open(390, { hasTouch: true, isMobile: true });
  const touch = await page.context().newCDPSession(page);
  const { x, y, width, height } = await page.locator('.v3-surface').first().boundingBox();
  const [centreX, centreY] = [x + width / 2, y + height / 2];
  async function stroke(places) {
    for (const [index, points] of places.entries()) {
      const touchPoints = points.map(([dx, dy], id) => ({ x: centreX + dx, y: centreY + dy, id }));
      await touch.send('Input.dispatchTouchEvent', { type: index ? 'touchMove' : 'touchStart', touchPoints });
    }
    await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  }
  const orbit = () => page.evaluate(() => ({ ...window.mimesh.stage.views[1].orbit }));
  const first = await orbit();
  await stroke([[[0, 0]], [[20, 0]], [[50, 0]]]);
  const turned = await orbit();
  assert.notEqual(turned.yaw, first.yaw);
  assert.equal(turned.distance, first.distance);
  await stroke([
    [
      [-20, 0],
      [20, 0],
    ],
    [
      [-40, 0],
      [40, 0],
    ],
    [
      [-60, 0],
      [60, 0],
    ],
  ]);
  const near = await orbit();
  assert.ok(near.distance < turned.distance * 0.6, `${near.distance} of ${turned.distance}`);
  assert.equal(near.yaw, turned.yaw);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('the wheel scrolls the page until a view is clicked', async () => {
  const page = await open(1200);
  const view = page.locator('.v3-surface').first();
  const distance = () => page.evaluate(() => window.mimesh.stage.views[0].orbit.distance);
  const before = await distance();
  await view.hover();
  await page.mouse.wheel(0, 60);
  assert.equal(await distance(), before);
  await view.click();
  await page.mouse.wheel(0, 60);
  await page.waitForFunction((far) => window.mimesh.stage.views[0].orbit.distance > far, before);
  await page.close();
});

test('axe finds nothing serious in the page, in light and dark, wide and narrow', async () => {
  for (const [width, colorScheme] of [
    [1200, 'light'],
    [390, 'light'],
    [390, 'dark'],
  ]) {
    const page = await open(width, { colorScheme });
    await page.evaluate(AXE);
    const found = await page.evaluate(() => window.axe.run(document));
    const serious = found.violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
    assert.deepEqual(
      serious.map(({ id, nodes }) => `${id}: ${nodes[0].html.slice(0, 120)}`),
      [],
    );
    await page.close();
  }
});

test('without WebGL or scripts the pictures stay, and a sentence says why', async () => {
  const plain = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-3d-apis', '--disable-gpu'],
  });
  const page = await open(1200, { browser: plain });
  assert.match(await page.locator('#view-3d').textContent(), /has no WebGL 2/);
  assert.equal(await page.locator('#view-3d canvas').count(), 0);
  assert.ok((await page.locator('img').count()) >= 8);
  await page.close();
  await plain.close();
  const still = await open(1200, { javaScriptEnabled: false });
  assert.ok(await still.getByText('The view needs scripts').isVisible());
  await still.close();
});
