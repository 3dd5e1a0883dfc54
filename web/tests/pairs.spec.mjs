// Pairs in use: what is selected after each step, mirrors of one pair, keys after a list, and what the top of the page says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { atRest, openPage, pairs, saved, studioOfFile } from './browser.mjs';
import { freePlace } from './places.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 40 });
const selected = (page) => page.evaluate(() => window.mimesh.studio.selected.peek());
const select = (page, id) => page.click(`.pair[data-pair="${id}"]`);

async function clickFree(page, pane) {
  const { x, y } = await freePlace(page, pane);
  await page.mouse.click(x, y);
}

/** A page on which a pair was clicked, which is selected, and how many pairs there were before. */
async function withNewPair() {
  const page = await studio.open();
  await atRest(page);
  const { length } = await pairs(page);
  await clickFree(page, 'source');
  await clickFree(page, 'result');
  await saved(page);
  return { page, length };
}

test('a new pair stays selected when it is complete, and the next click begins another', async () => {
  const { page, length } = await withNewPair();
  const made = (await pairs(page)).at(-1);
  assert.equal(await selected(page), made.id);
  await page.fill('.detail input', 'hump');
  await page.keyboard.press('Enter');
  await saved(page);
  assert.match(await page.textContent('.pane-result .pane-hint'), /begin the next pair/);
  await clickFree(page, 'result');
  await saved(page);
  const now = await pairs(page);
  assert.equal(now.length, length + 2);
  assert.deepEqual(now.at(-2).target, made.target);
  assert.equal(now.at(-2).name, 'hump');
  assert.equal(await selected(page), now.at(-1).id);
  // One that was chosen is moved by a click.
  await select(page, made.id);
  await atRest(page);
  await clickFree(page, 'result');
  await saved(page);
  assert.equal((await pairs(page)).length, length + 2);
  assert.notDeepEqual((await pairs(page)).at(-2).target, made.target);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('a deleted pair that comes back is selected, and the views go there', async () => {
  const page = await studio.open();
  const [, pair] = (await pairs(page)).filter((one) => one.source && one.target);
  await select(page, pair.id);
  await atRest(page);
  const place = () => page.evaluate(() => window.mimesh.stage.pane('source').view.goal.target.toArray());
  const before = await place();
  await page.keyboard.press('Delete');
  await saved(page);
  assert.notEqual(await selected(page), pair.id);
  assert.notDeepEqual(await place(), before);
  await page.keyboard.press('Control+z');
  await page.waitForFunction((id) => window.mimesh.studio.selected.peek() === id, pair.id);
  assert.deepEqual(await place(), before);
  await page.close();
});

test('one pair is mirrored alone', async () => {
  const { page, length } = await withNewPair();
  await page.keyboard.press('m');
  await page.click('dialog >> text=/^Only /');
  await saved(page);
  const words = await page.textContent('.view-bar .notice-text');
  // Beyond the plane there may be a pair already; the mock mirrors nothing.
  const [, added] = /^Added (\w+) mirrored pair/.exec(words);
  assert.equal((await pairs(page)).length, length + 1 + Number(added));
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('the keys of the page work after a choice from a list by mouse', async () => {
  const page = await studio.open();
  const list = '.points-tools select';
  await page.click(list);
  await page.selectOption(list, 'number');
  assert.equal(await page.evaluate(() => document.activeElement === document.body), true);
  await page.keyboard.press('j');
  assert.notEqual(await selected(page), null);
  // By keyboard the list keeps the focus, and Escape leaves it.
  await page.focus(list);
  await page.keyboard.press('ArrowUp');
  assert.equal(await page.evaluate(() => document.activeElement.tagName), 'SELECT');
  await page.keyboard.press('Escape');
  assert.equal(await page.evaluate(() => document.activeElement === document.body), true);
  await page.close();
});

test('proposals are counted', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('text=Propose');
  const count = (await pairs(page)).filter((one) => one.status === 'proposed').length;
  await page.waitForSelector(`.notice-text >> text=${count} pairs were proposed.`);
  await page.close();
});

test('a pipeline with mistakes is not called saved, and Run says what will happen', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  const run = '.run-control .primary';
  await page.waitForFunction(() => /^Saved$/.test(document.querySelector('.save-state').textContent));
  assert.match(await page.getAttribute(run, 'title'), /writes out\/camel\.glb/);
  await page.evaluate(() => window.mimesh.studio.pipeline.set(['correspondence', 'steps'], 99));
  await page.waitForFunction(() => document.querySelector('.save-state').textContent === 'Mistakes');
  assert.match(await page.getAttribute(run, 'title'), /would stop .* must be from 1 to 20/);
  await page.close();
  await own.close();
});

test('Escape leaves the choice of files', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('.bar >> text=Open');
  await page.waitForSelector('.entry.mesh');
  await page.keyboard.press('Escape');
  await page.waitForSelector('.stage:visible');
  await page.close();
});

test('a finding turns its colours on, and the legend covers no view', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.setViewportSize({ width: 1024, height: 700 });
  assert.equal(await page.textContent('.pane-result .pane-hint'), 'Click to begin a pair');
  assert.ok(await page.isVisible('.pane-result .pane-hint'));
  await page.click('#tab-result');
  await page.click('.worst-entry >> nth=0');
  await page.waitForSelector('.legend:visible');
  assert.equal(await page.inputValue('.result select'), 'edge_stretch');
  const [legend, view] = await Promise.all(
    ['.legend', '.pane-result .pane-surface'].map((one) => page.locator(one).boundingBox()),
  );
  assert.ok(view.y + view.height <= legend.y, `${view.y + view.height} ${legend.y}`);
  assert.ok(await page.isVisible('.pane-result .pane-hint'));
  await page.close();
});

test('a source of shapes has a timeline whose words are all read', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40, shapes: true });
  const page = await openPage(studio.browser, own.url);
  const cut = await page.evaluate(() => {
    const name = document.querySelector('.pose-name');
    return name.scrollWidth - name.clientWidth;
  });
  assert.ok(cut <= 0, `${cut}`);
  await page.close();
  await own.close();
});
