// Messages: how long they stay, where they can be read again, and what undo says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openPage, pairs, saved, studioOfFile } from './browser.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 40 });
const line = '.view-bar .notice-text';
const tell = (page, text, hint = null) =>
  page.evaluate((said) => window.mimesh.studio.markers.onNotice(said), { text, hint });

test('points and settings are undone in the order in which they were done, and the page says what', async () => {
  const page = await studio.open();
  const pair = (await pairs(page)).find((one) => one.source && one.target);
  await page.evaluate((id) => {
    window.mimesh.studio.markers.edit({ op: 'rename', pair: id, name: 'first-name' });
  }, pair.id);
  await saved(page);
  await page.evaluate(() => window.mimesh.studio.pipeline.set(['output'], 'other.glb'));
  assert.match(await page.getAttribute('[aria-label="Undo"]', 'title'), /Undo: set output/);
  await page.click('[aria-label="Undo"]');
  await page.waitForFunction(() =>
    /Undid: set output/.test(document.querySelector('.view-bar .notice-text').textContent),
  );
  await page.click('[aria-label="Undo"]');
  await page.waitForFunction(() => /Undid: renamed/.test(document.querySelector('.view-bar .notice-text').textContent));
  assert.equal((await pairs(page)).find((one) => one.id === pair.id).name, pair.name);
  await page.click('[aria-label="Redo"]');
  await page.waitForFunction(() =>
    /Did again: renamed/.test(document.querySelector('.view-bar .notice-text').textContent),
  );
  await page.click('[aria-label="Undo"]');
  await page.waitForFunction((n) => window.mimesh.studio.markers.pairs.peek().some((one) => one.name === n), pair.name);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('messages cover no mesh, before and after they vanish', async () => {
  const page = await studio.open();
  for (let i = 0; i < 4; i++)
    await page.evaluate((n) => window.mimesh.studio.markers.onNotice({ text: `Told ${n}`, hint: 'A hint.' }), i);
  await page.waitForSelector('.notice-line strong:visible');
  const line = await page.locator('.view-bar .notice-line').boundingBox();
  for (const pane of ['.pane-source', '.pane-result']) {
    const view = await page.locator(`${pane} .pane-surface`).boundingBox();
    assert.ok(line.y + line.height <= view.y, pane);
  }
  await page.click('.notice-line button:has-text("All")');
  assert.ok((await page.locator('.messages .notice').count()) >= 4);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('a message that is cut or read stays until it is closed, and all can be read again', async () => {
  const page = await studio.browser.newPage({ viewport: { width: 1280, height: 720 } });
  await page.clock.install();
  await page.goto(studio.server.url);
  await page.waitForFunction(() => window.mimesh?.studio.phase.peek().name === 'ready');
  const height = () => page.evaluate(() => document.querySelector('.view-bar').offsetHeight);
  const before = await height();
  await tell(page, 'A short one.');
  await page.waitForSelector('text=A short one.');
  await page.clock.runFor(7000);
  assert.equal(await page.textContent(line), '');
  const long = `A long one: ${'one pair after another has no partner, '.repeat(12)}and that is all.`;
  await tell(page, long);
  await page.waitForFunction(() => document.querySelector('.view-bar .notice-text').textContent.startsWith('A long'));
  assert.equal(await height(), before);
  await page.clock.runFor(20000);
  assert.equal(await page.textContent(line), long);
  await page.click('.view-bar [aria-label="Dismiss"]');
  assert.equal(await page.textContent(line), '');
  await tell(page, 'Another short one, with `code`.');
  await page.click('.view-bar .notice-line button:has-text("In full")');
  await page.clock.runFor(20000);
  assert.ok(await page.isVisible('.view-bar .messages .notice'));
  assert.equal(await page.textContent('.view-bar .messages code'), 'code');
  // The program has messages of its own.
  const said = await page.locator('.view-bar .notice-earlier p').allTextContents();
  assert.deepEqual(
    said.filter((text) => text.startsWith('A ')),
    [long, 'A short one.'],
  );
  await page.click('.view-bar .messages [aria-label="Dismiss"]');
  await page.keyboard.press('Escape');
  assert.equal(await page.textContent('.view-bar .notice-line > .button:visible'), 'Messages');
  await page.close();
});

test('an error about the pipeline goes when the pipeline is another', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  await page.route('**/api/run', (route) =>
    route.fulfill({
      status: 422,
      json: { error: { code: 'unprocessable', message: 'steps is 99', hint: null, diagnostics: [] } },
    }),
  );
  await page.evaluate(() => window.mimesh.studio.pipeline.set(['correspondence', 'steps'], 99));
  await page.click('.run-control .primary');
  await page.waitForFunction(() => /Steps is 99/.test(document.querySelector('.view-bar .notice-text').textContent));
  await page.click('[aria-label="Undo"]');
  await page.waitForFunction(() => /^Undid/.test(document.querySelector('.view-bar .notice-text').textContent));
  assert.equal(await page.locator('.notice-line[data-level="error"]').count(), 0);
  await page.click('.notice-line button:visible:has-text("In full")');
  assert.equal(await page.locator('.view-bar .messages .notice.error').count(), 0);
  await page.close();
  await own.close();
});
