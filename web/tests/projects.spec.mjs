// One project after another: what is shown is of the one that is open. And the choice of its files.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { loaded, openPage, pairs, saved, studioOfFile } from './browser.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 40, open: false });

const slots = (page) => page.locator('.slot-name').allTextContents();

async function openFiles(page, source, target) {
  await page.waitForSelector('.entry.mesh');
  await page.click(`.entry.mesh >> text=${source}`);
  await page.click(`.entry.mesh >> text=${target}`);
  await page.click('.slots > .button');
  await page.waitForFunction(
    (title) => window.mimesh.studio.phase.peek().name === 'ready' && document.title.startsWith(title),
    `${target.split('.')[0]}-from-${source.split('.')[0]}`,
  );
  await loaded(page);
}

test('another pair is opened after Stages was seen, and has neither the meshes nor the run of the one before', {
  skip: !mocked,
}, async () => {
  const page = await openPage(studio.browser, studio.server.url, { ready: false });
  await openFiles(page, 'horse.glb', 'camel.glb');
  await page.click('#tab-stages');
  await page.waitForSelector('.group');
  await page.click('.run-control .primary');
  await page.waitForSelector('.total');
  const vertices = () => page.evaluate(() => window.mimesh.stage.pane('source').surface.positions.length);
  const before = await vertices();
  await page.click('.bar >> text=Open');
  await openFiles(page, 'camel.glb', 'horse.glb');
  assert.notEqual(await vertices(), before);
  assert.equal(await page.locator('[aria-label="Last run"]:visible').count(), 0);
  await page.click('#tab-stages');
  await page.waitForSelector('.group');
  await page.click('.bar >> text=Open');
  await openFiles(page, 'horse.glb', 'camel.glb');
  assert.equal(await vertices(), before);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('an effect that throws is told, and the rest of the page goes on', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  await page.click('#tab-stages');
  await page.waitForSelector('.group');
  await page.evaluate(() => {
    const { pipeline } = window.mimesh.studio.pipeline;
    pipeline.value = { ...pipeline.peek(), diagnostics: null };
  });
  await page.waitForFunction(() =>
    /could not be updated/.test(document.querySelector('.view-bar .notice-text').textContent),
  );
  await page.click('#tab-result');
  await page.waitForSelector('[aria-label="Live result"]:visible');
  await page.close();
  await own.close();
});

test('a box is chosen for the next file, sides are swapped, and a file that cannot be read takes no other with it', {
  skip: !mocked,
}, async () => {
  const own = await serve({ resolution: 40, open: false });
  const page = await openPage(studio.browser, own.url, { ready: false });
  await page.waitForSelector('.entry.mesh');
  await page.click('[aria-label="Target"] .slot-choice');
  await page.click('.entry.mesh >> text=broken.obj');
  assert.equal((await slots(page))[1], 'broken.obj');
  // The other box was empty, so it is next.
  await page.click('.entry.mesh >> text=camel.glb');
  await page.click('[aria-label="Swap"]');
  assert.deepEqual(await slots(page), ['broken.obj', 'camel.glb']);
  await page.click('.slots > .button');
  await page.waitForSelector('.failed');
  await page.click('text=Choose other files');
  assert.equal((await slots(page))[1], 'camel.glb');
  assert.equal(await page.locator('.slot.filled').count(), 1);
  await page.waitForSelector('.entry.mesh');
  await page.click('.entry.mesh >> text=horse.glb');
  assert.deepEqual(await slots(page), ['horse.glb', 'camel.glb']);
  await page.click('.slots > .button');
  await loaded(page);
  await page.close();
  await own.close();
});

test('when all pairs are checked, Run takes the place of Next', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  const run = page.locator('.points-head .primary', { hasText: 'Run' });
  assert.equal(await run.isVisible(), false);
  await page.click('.points-head .primary');
  await page.waitForFunction(() => /sure/.test(document.querySelector('.view-bar .notice-text').textContent));
  await page.keyboard.press('c');
  // Why the pair was shown is no news once it is confirmed.
  await page.waitForFunction(() => !/sure/.test(document.querySelector('.view-bar .notice-text').textContent));
  for (const pair of await pairs(page)) {
    if (pair.status !== 'proposed') continue;
    const status = pair.source && pair.target ? 'confirmed' : 'skipped';
    await page.evaluate((op) => window.mimesh.studio.markers.edit(op), { op: 'status', pair: pair.id, status });
  }
  await saved(page);
  await page.waitForSelector('text=All pairs are checked. Run writes the result.');
  await run.click();
  await page.waitForSelector('.total');
  await page.close();
  await own.close();
});
