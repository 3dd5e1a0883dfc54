// Points by real mouse and keyboard.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { atRest, openPage, pairs, pairWith, saved, studioOfFile } from './browser.mjs';
import { draggable, freePlace, pointOnScreen } from './places.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 60 });

test('a drag moves the point over the surface, undo brings it back, and both outlive a reload', async () => {
  const page = await studio.open();
  const pair = await draggable(page, 'result', [12, 6]);
  const from = await pointOnScreen(page, 'result', pair.id);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + 12, from.y + 6, { steps: 6 });
  await page.waitForFunction(() => window.mimesh.studio.dragged.peek() !== null);
  await page.mouse.up();
  await saved(page);
  const moved = (await pairs(page)).find((one) => one.id === pair.id);
  assert.notDeepEqual(moved.target, pair.target);
  assert.ok(Math.abs(moved.target.barycentric.reduce((sum, weight) => sum + weight, 0) - 1) < 1e-9);
  await page.reload();
  await page.waitForFunction(() => window.mimesh?.studio.phase.peek().name === 'ready');
  assert.deepEqual((await pairs(page)).find((one) => one.id === pair.id).target, moved.target);
  await page.keyboard.press('Control+z');
  await page.waitForFunction(
    ([id, point]) => JSON.stringify(window.mimesh.studio.markers.pair(id).target) === point,
    [pair.id, JSON.stringify(pair.target)],
  );
  await page.keyboard.press('Control+Shift+z');
  await page.waitForFunction(
    ([id, point]) => JSON.stringify(window.mimesh.studio.markers.pair(id).target) === point,
    [pair.id, JSON.stringify(moved.target)],
  );
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('a click on each mesh makes a pair, and Shift snaps to a vertex', async () => {
  const page = await studio.open();
  const count = (await pairs(page)).length;
  const [source, target] = [await freePlace(page, 'source'), await freePlace(page, 'result')];
  await page.mouse.click(source.x, source.y);
  await page.waitForFunction((n) => window.mimesh.studio.markers.pairs.peek().length === n, count + 1);
  await page.keyboard.down('Shift');
  await page.mouse.click(target.x, target.y);
  await page.keyboard.up('Shift');
  await saved(page);
  const made = (await pairs(page)).at(-1);
  assert.ok('triangle' in made.source);
  assert.ok('vertex' in made.target);
  assert.equal(made.status, 'confirmed');
  assert.equal(await page.evaluate(() => window.mimesh.studio.selected.peek()), made.id);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('everything is done by keys alone', async () => {
  const page = await studio.open();
  const proposed = (await pairs(page)).filter((one) => one.status === 'proposed').length;
  await page.keyboard.press('j');
  await page.waitForFunction(() => window.mimesh.studio.selected.peek() !== null);
  const first = await page.evaluate(() => window.mimesh.studio.selected.peek());
  await page.keyboard.press('r');
  await page.keyboard.type('chosen by keys');
  await page.keyboard.press('Enter');
  await saved(page);
  assert.equal((await pairs(page)).find((one) => one.id === first).name, 'chosen by keys');
  // The first of the list may lack a partner, which cannot be confirmed.
  await page.keyboard.press('j');
  await page.keyboard.press('c');
  await page.keyboard.press('s');
  await saved(page);
  assert.equal((await pairs(page)).filter((one) => one.status === 'proposed').length, proposed - 2);
  await page.keyboard.press('Escape');
  // A point at the centre of a view, pushed about.
  await page.keyboard.press('Home');
  await atRest(page);
  await page.focus('.pane-source .pane-surface');
  const count = (await pairs(page)).length;
  await page.keyboard.press('Enter');
  await saved(page);
  const made = (await pairs(page)).at(-1);
  assert.equal((await pairs(page)).length, count + 1);
  await page.keyboard.press('Alt+ArrowRight');
  await page.keyboard.press('Alt+ArrowRight');
  await saved(page);
  assert.notDeepEqual((await pairs(page)).at(-1).source, made.source);
  await page.keyboard.press('Delete');
  await saved(page);
  assert.equal((await pairs(page)).length, count);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('two pages see each other, and the later of two edits of one point is told', async () => {
  const [one, two] = [await studio.open(), await studio.open()];
  const pair = await pairWith(one, (other) => other.source && other.target);
  const edit = (page, vertex) =>
    page.evaluate(
      ([id, v]) =>
        void window.mimesh.studio.markers.edit({ op: 'move', pair: id, side: 'target', point: { vertex: v } }),
      [pair.id, vertex],
    );
  // The second page edits before it has heard of the first edit, and sends its own after that.
  let send;
  const due = new Promise((resolve) => {
    send = resolve;
  });
  await two.route('**/api/markers', (route) => due.then(() => route.continue()));
  await edit(two, 20);
  await edit(one, 10);
  await saved(one);
  send();
  await saved(two);
  const target = JSON.stringify((await pairs(one)).find((other) => other.id === pair.id).target);
  await two.waitForFunction(
    ([id, point]) => JSON.stringify(window.mimesh.studio.markers.pair(id).target) === point,
    [pair.id, target],
  );
  assert.deepEqual(JSON.parse(target), { vertex: 10 });
  assert.deepEqual([await one.locator('.conflict').count(), await two.locator('.conflict').count()], [0, 1]);
  await Promise.all([one.close(), two.close()]);
});

// The mock alone can cut the line of one page.
test('edits without a connection wait in the browser and are sent when it is back', {
  skip: !mocked,
}, async () => {
  const own = await serve({ resolution: 40 });
  const page = await openPage(studio.browser, own.url);
  const pair = await pairWith(page, (one) => one.target);
  await page.route('**/api/**', (route) => route.abort());
  for (const socket of own.mock.sockets) socket.terminate();
  await page.evaluate(
    (id) => void window.mimesh.studio.markers.edit({ op: 'rename', pair: id, name: 'kept' }),
    pair.id,
  );
  await page.waitForFunction(() => /kept in this browser/.test(document.querySelector('.save-state').textContent));
  await page.unroute('**/api/**');
  await page.reload();
  await page.waitForFunction(() => window.mimesh?.studio.phase.peek().name === 'ready');
  await saved(page);
  assert.equal(own.mock.project.markers.view().pairs.find((one) => one.id === pair.id).name, 'kept');
  await page.close();
  await own.close();
});
