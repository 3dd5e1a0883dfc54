// The states of the page, in light and dark: no error, no serious finding of axe, nothing that moves by itself.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { atRest, openPage, studioOfFile } from './browser.mjs';
import { mocked, serve } from './servers.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const studio = studioOfFile({ resolution: 50 });

async function findings(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html.slice(0, 120)).join(' | ')}`);
}

/** Waits until no camera flies and no style is on its way. */
async function unmoved(page) {
  await atRest(page);
  await page.waitForFunction(() => document.getAnimations().every((animation) => animation.playState !== 'running'));
}

const STATES = {
  points: async (page) => page.keyboard.press('j'),
  result: async (page) => page.click('#tab-result'),
  colours: async (page) => {
    await page.click('#tab-result');
    await page.selectOption('.result select', { index: 1 });
    await page.waitForSelector('.legend:visible');
  },
  stages: async (page) => {
    await page.click('#tab-stages');
    await page.waitForSelector('.group');
  },
  paint: async (page) => page.click('#tab-paint'),
  help: async (page) => page.keyboard.press('?'),
  mirror: async (page) => page.keyboard.press('m'),
  components: async (page) => page.click('.components-menu > button'),
  about: async (page) => {
    await page.click('[aria-label="About"]');
    await page.waitForSelector('.about summary');
  },
};

// The server changes no colours, so one theme is enough on the program.
for (const theme of mocked ? ['light', 'dark'] : ['light']) {
  for (const [name, enter] of Object.entries(STATES)) {
    test(`${name}, ${theme}`, async () => {
      const page = await studio.open({ theme });
      await enter(page);
      await unmoved(page);
      assert.deepEqual(await findings(page), []);
      assert.deepEqual(page.errors, []);
      await page.close();
    });
  }

  // The program opens its samples at once; its start page is part of the whole job.
  test(`start and a file that cannot be read, ${theme}`, { skip: !mocked }, async () => {
    const empty = await serve({ resolution: 40, open: false });
    const page = await openPage(studio.browser, empty.url, { theme, ready: false });
    await page.waitForSelector('.entry.mesh');
    assert.deepEqual(await findings(page), []);
    await page.click('text=horse.glb');
    await page.click('text=broken.obj');
    await page.click('.slots > .button');
    await page.waitForSelector('.failed');
    assert.match(await page.textContent('.failed'), /line 12/);
    assert.deepEqual(await findings(page), []);
    await page.click('text=Choose other files');
    await page.setInputFiles('#upload', {
      name: 'horse.glb',
      mimeType: 'model/gltf-binary',
      buffer: Buffer.from('glTF'),
    });
    await page.waitForSelector('.slot.filled');
    await page.click('text=camel.glb');
    await page.click('.slots > .button');
    await page.waitForFunction(() => window.mimesh.studio.phase.peek().name === 'ready');
    await page.close();
    await empty.close();
  });
}

test('nothing moves by itself while the page loads and is used', async () => {
  const page = await studio.browser.newPage({ viewport: { width: 1280, height: 720 } });
  await page.addInitScript(() => {
    window.shifts = 0;
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) if (!entry.hadRecentInput) window.shifts += entry.value;
    }).observe({ type: 'layout-shift', buffered: true });
  });
  await page.goto(studio.server.url);
  await page.waitForFunction(() => window.mimesh?.studio.phase.peek().name === 'ready');
  for (const key of ['j', 'j', '.', '.', 'Escape']) {
    await page.keyboard.press(key);
    // For half a second after a key the browser takes every shift for its effect.
    await page.waitForTimeout(700);
  }
  assert.ok((await page.evaluate(() => window.shifts)) < 0.02);
  await page.close();
});
