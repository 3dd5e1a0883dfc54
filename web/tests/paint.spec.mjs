// Painting: what is saved, what is undone, what outlives a clip and a reload, and what a pipeline takes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { loaded, openPage, studioOfFile } from './browser.mjs';
import { freePlace } from './places.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 50 });

/** Waits until what is painted is saved; before, the page says “not saved yet”. */
const isSaved = (page) =>
  page.waitForFunction(() => document.querySelector('[aria-label="Save"] .muted').textContent === 'saved');
const painted = (page) =>
  page.evaluate(() => window.mimesh.studio.painting.draft().mask.weights.reduce((sum, weight) => sum + weight, 0));
const undoSays = (page) => page.getAttribute('[aria-label="Undo"]', 'title');
const message = (page, pattern) =>
  page.waitForFunction(
    (source) => new RegExp(source).test(document.querySelector('.view-bar .notice-text').textContent),
    pattern.source,
  );

/** A stroke over the target. */
async function stroke(page, dy = 0) {
  const box = await page.locator('.pane-result .pane-surface').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height * 0.45 + dy];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y, { steps: 4 });
  await page.mouse.up();
}

test('the button and the key undo the same: strokes and settings in the order in which they were done', {
  skip: !mocked,
}, async () => {
  const own = await serve({ resolution: 40, shapes: true });
  const page = await openPage(studio.browser, own.url);
  await page.click('#tab-paint');
  await stroke(page);
  assert.equal(await undoSays(page), 'Undo: the stroke (Ctrl Z)');
  const first = await painted(page);
  assert.ok(first > 0);
  await page.click('[aria-label="Save"] .primary');
  await isSaved(page);
  await page.click('text=Use in the pipeline');
  await message(page, /Ctrl Z takes it back/);
  assert.match(await undoSays(page), /^Undo: set shapes/);
  await stroke(page, 8);
  await page.keyboard.press('Control+z');
  await message(page, /Undid: the stroke\./);
  assert.equal(await painted(page), first);
  // What is painted is what the file holds again.
  await isSaved(page);
  assert.match(await page.textContent('.save-state'), /^Saved$/);
  await page.keyboard.press('Control+z');
  await message(page, /Undid: set shapes/);
  await page.click('[aria-label="Undo"]');
  await message(page, /Undid: the stroke\./);
  assert.equal(await painted(page), 0);
  // The stroke is there again on any tab, and is shown.
  await page.click('#tab-points');
  await page.click('[aria-label="Redo"]');
  await page.waitForSelector('.paint:visible');
  assert.equal(await painted(page), first);
  assert.deepEqual(page.errors, []);
  await page.close();
  await own.close();
});

test('strokes outlive another clip and another project, and a reload asks first', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  await page.click('#tab-paint');
  await stroke(page);
  const sum = await painted(page);
  assert.ok(sum > 0);
  assert.match(await page.textContent('.save-state'), /not saved/);
  await page.selectOption('.clip-choice select', 'Run');
  await page.waitForFunction(() => window.mimesh.studio.session.peek().poses.list[0].clip === 'Run');
  await loaded(page);
  assert.equal(await painted(page), sum);
  // The other mesh has strokes of its own.
  await page.selectOption('.paint select >> nth=1', 'source');
  assert.equal(await painted(page), 0);
  await page.selectOption('.paint select >> nth=1', 'target');
  assert.equal(await painted(page), sum);
  const open = (source, target) =>
    page.evaluate((what) => window.mimesh.studio.open(what), {
      source: `/meshes/${source}`,
      target: `/meshes/${target}`,
    });
  await open('camel.glb', 'horse.glb');
  await message(page, /painted on camel\.glb is not saved/);
  assert.equal(await painted(page), 0);
  await open('horse.glb', 'camel.glb');
  await page.waitForFunction(() => /not saved/.test(document.querySelector('.save-state').textContent));
  await page.waitForFunction(
    () => window.mimesh.studio.session.peek().target.file === 'camel.glb' && window.mimesh.studio.painting.due(false),
  );
  assert.equal(await painted(page), sum);
  const asked = page.waitForEvent('dialog');
  const reloaded = page.evaluate(() => location.reload());
  const dialog = await asked;
  assert.equal(dialog.type(), 'beforeunload');
  await dialog.dismiss();
  await reloaded;
  assert.equal(await painted(page), sum);
  assert.deepEqual(page.errors, []);
  await page.close();
  await own.close();
});

test('each kind of mask has a name of its own, overwriting asks, and a saved one goes into the pipeline', {
  skip: !mocked,
}, async () => {
  const page = await studio.open();
  await page.click('#tab-paint');
  const name = '[aria-label="Save"] input[maxlength="60"]';
  assert.equal(await page.inputValue(name), 'weights');
  await page.click('text=Fill');
  await page.click('[aria-label="Save"] .primary');
  await page.waitForSelector('.masks .link');
  // The same mask again asks nothing.
  await page.click('text=Invert');
  await page.click('[aria-label="Save"] .primary');
  await isSaved(page);
  assert.equal(await page.locator('dialog[open]').count(), 0);
  await page.selectOption('.paint select >> nth=0', 'components');
  assert.equal(await page.inputValue(name), 'rigid');
  await page.fill(name, 'weights');
  await page.click('[aria-label="Save"] .primary');
  await page.waitForSelector('dialog[open]');
  await page.click('dialog >> text=Keep it');
  await page.fill(name, 'rigid');
  const place = await freePlace(page, 'result');
  await page.mouse.click(place.x, place.y);
  await page.click('[aria-label="Save"] .primary');
  await page.waitForFunction(() => document.querySelectorAll('.masks .link').length === 2);
  await page.click('text=Use in the pipeline');
  await page.waitForFunction(() => window.mimesh.studio.pipeline.pipeline.peek().value.transfer.rigid?.length === 1);
  await page.close();
});

test('a name that is typed while a mask of the other kind is saved stays', { skip: !mocked }, async () => {
  const page = await studio.open();
  let answer;
  const asked = new Promise((resolve) => {
    answer = resolve;
  });
  await page.route('**/api/masks/**', async (route) => {
    await asked;
    await route.continue();
  });
  await page.click('#tab-paint');
  const name = '[aria-label="Save"] input[maxlength="60"]';
  await page.click('text=Fill');
  await page.fill(name, 'late');
  await page.click('[aria-label="Save"] .primary');
  await page.selectOption('.paint select >> nth=0', 'components');
  await page.fill(name, 'teeth');
  answer();
  await page.waitForSelector('.masks .link');
  assert.equal(await page.inputValue(name), 'teeth');
  await page.selectOption('.paint select >> nth=0', 'weights');
  assert.equal(await page.inputValue(name), 'late');
  await isSaved(page);
  await page.close();
});

test('masks are for shapes: a source of frames is told so before painting, and one of shapes takes them', {
  skip: !mocked,
}, async () => {
  const frames = await studio.open();
  await frames.click('#tab-paint');
  await frames.waitForSelector('.mask-note:visible');
  await frames.selectOption('.paint select >> nth=0', 'components');
  assert.equal(await frames.locator('.mask-note:visible').count(), 0);
  await frames.selectOption('.paint select >> nth=0', 'weights');
  await frames.click('text=Fill');
  await frames.fill('[aria-label="Save"] input[maxlength="60"]', 'of-frames');
  await frames.click('[aria-label="Save"] .primary');
  await frames.waitForSelector('.use .button');
  assert.ok(await frames.isDisabled('.use .button'));
  // What is undone of the brush is said.
  await frames.keyboard.press('Control+z');
  await frames.waitForFunction(() => /the filling/.test(document.querySelector('.view-bar .notice-text').textContent));
  await frames.close();

  const own = await serve({ resolution: 50, shapes: true });
  const page = await openPage(studio.browser, own.url);
  await page.click('#tab-paint');
  assert.equal(await page.locator('.mask-note:visible').count(), 0);
  await page.click('text=Fill');
  await page.click('[aria-label="Save"] .primary');
  await page.click('text=Use in the pipeline');
  await page.waitForFunction(() => window.mimesh.studio.pipeline.pipeline.peek().value.shapes?.masks['*']);
  await page.close();
  await own.close();
});
