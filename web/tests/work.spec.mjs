// Motion, colours, forms, painting and runs.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { studioOfFile } from './browser.mjs';
import { draggable, pointOnScreen } from './places.mjs';
import { mocked } from './servers.mjs';

const studio = studioOfFile({ resolution: 60 });

test('the timeline scrubs, plays at the rate of the clip and shows each pose on both meshes', async () => {
  const page = await studio.open();
  await page.keyboard.press('.');
  await page.waitForFunction(() => window.mimesh.studio.live.source.peek()?.header.pose?.index === 0);
  const box = await page.locator('.timeline input').boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForFunction(() => {
    const { live } = window.mimesh.studio;
    const wanted = live.pose.peek().index;
    return (
      wanted > 2 && live.source.peek().header.pose?.index === wanted && live.target.peek().header.pose?.index === wanted
    );
  });
  await page.focus('.pane-source .pane-surface');
  await page.keyboard.press('Space');
  const start = await page.evaluate(() => window.mimesh.studio.live.pose.peek().index);
  await page.waitForFunction((from) => window.mimesh.studio.live.pose.peek().index !== from, start);
  await page.keyboard.press('Space');
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('colours have a legend with figures and unit', async () => {
  const page = await studio.open();
  await page.click('#tab-result');
  await page.selectOption('.result select', 'edge_stretch');
  await page.waitForSelector('.legend:visible');
  assert.match(await page.textContent('.legend'), /stretch/);
  assert.equal(await page.locator('.legend-figures span').count(), 5);
  await page.selectOption('.result select', 'pair_confidence');
  await page.waitForFunction(() => /confidence, %/.test(document.querySelector('.legend').textContent));
  assert.match(await page.textContent('.legend-figures'), /^0.*100$/);
  assert.deepEqual(page.errors, []);
  await page.close();
});

// Whether anything is above its limit depends on the samples.
test('the worst list flies and sets the pose', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('#tab-result');
  const entry = page.locator('.worst-entry').first();
  await entry.waitFor();
  await entry.click();
  await page.waitForFunction(() => window.mimesh.studio.live.pose.peek() !== null);
  await page.close();
});

test('a drag is previewed while the hand moves', async () => {
  const page = await studio.open();
  const { id } = await draggable(page, 'result', [12, 6]);
  const from = await pointOnScreen(page, 'result', id);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 12; i++) await page.mouse.move(from.x + i, from.y + i / 2);
  await page.waitForFunction(() => window.mimesh.studio.live.target.peek().header.drag !== null);
  await page.keyboard.press('Escape');
  await page.mouse.up();
  await page.waitForFunction(() => window.mimesh.studio.dragged.peek() === null);
  assert.deepEqual(page.errors, []);
  await page.close();
});

// It names settings, limits and comments of the pipeline of the mock.
test('forms and text are one document, with errors at the field', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('#tab-stages');
  await page.click('[data-path="correspondence:fold"]');
  await page.fill('[data-path="correspondence.steps"]', '7');
  await page.press('[data-path="correspondence.steps"]', 'Enter');
  await page.waitForFunction(() => document.querySelector('.yaml').value.includes('steps: 7'));
  const text = await page.inputValue('.yaml');
  assert.match(text, /# A walk of a horse/);
  await page.fill('.yaml', text.replace('steps: 7', 'steps: 99'));
  await page.waitForSelector('.setting.faulty');
  assert.match(await page.textContent('.setting.faulty'), /from 1 to 20/);
  assert.match(await page.textContent('.faults'), /Line \d+/);
  await page.selectOption('[data-path="transfer"]', 'gradient');
  await page.waitForFunction(() => document.querySelector('.yaml').value.includes('type: gradient'));
  await page.fill('.yaml', 'a: [');
  await page.waitForFunction(() => /no YAML/.test(document.querySelector('.form').textContent));
  await page.fill('.yaml', text);
  await page.waitForSelector('[data-path="correspondence.steps"]');
  assert.deepEqual(page.errors, []);
  await page.close();
});

// A run of small samples may be over before a hand has cancelled it; the whole job has a run of the program.
test('a run shows its progress, can be cancelled, and links its files', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('.run-control .primary');
  await page.waitForSelector('.job:visible');
  await page.click('.job >> text=Cancel');
  await page.waitForSelector('.run-control .primary:visible');
  await page.click('.run-control .primary');
  await page.waitForSelector('.files a');
  assert.equal(await page.locator('.files a').count(), 2);
  await page.close();
});

test('a painted mask is saved and comes back', async () => {
  const page = await studio.open();
  await page.click('#tab-paint');
  const box = await page.locator('.pane-result').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height * 0.42);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 40, box.y + box.height * 0.42, { steps: 6 });
  await page.mouse.up();
  const painted = await page.evaluate(() =>
    window.mimesh.stage.painted.peek().values.reduce((sum, weight) => sum + weight, 0),
  );
  assert.ok(painted > 1);
  await page.fill('.paint input[type="text"]', 'hump');
  await page.click('.paint .primary');
  await page.waitForSelector('.masks .link');
  await page.click('text=Empty');
  await page.click('.masks .link');
  await page.waitForFunction(
    (sum) => Math.abs(window.mimesh.stage.painted.peek().values.reduce((a, b) => a + b, 0) - sum) < 1e-3,
    painted,
  );
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('components are hidden, isolated and shown', async () => {
  const page = await studio.open();
  const box = await page.locator('.pane-result').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height * 0.42);
  await page.keyboard.press('h');
  assert.equal(await page.evaluate(() => window.mimesh.studio.hidden.target.peek().size), 1);
  await page.keyboard.press('u');
  assert.equal(await page.evaluate(() => window.mimesh.studio.hidden.target.peek().size), 0);
  await page.close();
});
