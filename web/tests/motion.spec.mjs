// Playing results, clips, free values of forms, and places of a run.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { atRest, openPage, pairs, saved, studioOfFile } from './browser.mjs';
import { mocked, serve } from './servers.mjs';

const studio = studioOfFile({ resolution: 50, ahead: 4000 });

const channel = (page) => page.evaluate(() => window.mimesh.studio.live.target.peek()?.header.channel);
const shownOption = (page) =>
  page.evaluate(() => document.querySelector('.pane-result select').selectedOptions[0].textContent);

test('play shows the rough preview with a loud word, and the result as soon as all frames are there', async () => {
  const page = await studio.open();
  await page.focus('.pane-source .pane-surface');
  // A change of points takes all results away.
  const [first] = await pairs(page);
  await page.evaluate((id) => {
    const { markers } = window.mimesh.studio;
    markers.edit({ op: 'note', pair: id, note: 'x' });
  }, first.id);
  await saved(page);
  await page.keyboard.press('Space');
  await page.waitForFunction(() => window.mimesh.studio.live.target.peek()?.header.channel === 'preview');
  // All of it at one moment, since the results come meanwhile.
  const said = await page.evaluate(() => {
    const [badge, choice] = ['.shown-badge', 'select'].map((one) => document.querySelector(`.pane-result ${one}`));
    const { channel: of } = window.mimesh.studio.live.target.peek().header;
    return { of, badge: badge.hidden ? '' : badge.textContent, choice: choice.selectedOptions[0].textContent };
  });
  if (said.of === 'preview') {
    assert.match(said.badge, /^Rough preview · /);
    assert.equal(said.choice, 'Rough preview');
  } else assert.deepEqual(said, { of: 'result', badge: '', choice: 'Result' });
  await page.waitForFunction(() => window.mimesh.studio.live.playable.value !== null);
  await page.waitForFunction(() => window.mimesh.studio.live.target.peek()?.header.channel === 'result');
  // It stays the result, frame after frame.
  const start = await page.evaluate(() => window.mimesh.studio.live.target.peek().header.look);
  await page.waitForFunction((look) => window.mimesh.studio.live.target.peek().header.look > look + 5, start);
  assert.equal(await channel(page), 'result');
  assert.equal(await shownOption(page), 'Result');
  assert.equal(await page.locator('.pane-result .shown-badge:visible').count(), 0);
  await page.keyboard.press('Space');
  await page.waitForTimeout(200);
  const stopped = await page.evaluate(() => JSON.stringify(window.mimesh.studio.live.pose.peek()));
  await page.waitForTimeout(300);
  assert.equal(await page.evaluate(() => JSON.stringify(window.mimesh.studio.live.pose.peek())), stopped);
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('clips of the source are listed, and another one is chosen', { skip: !mocked }, async () => {
  const page = await studio.open();
  const options = await page.locator('.clip-choice option').allTextContents();
  assert.deepEqual(options, ['Walk · 1.00 s, 24 frames', 'Run · 0.50 s, 12 frames', 'All 2 clips']);
  await page.selectOption('.clip-choice select', 'Run');
  await page.waitForFunction(() => window.mimesh.studio.session.peek().poses.list[0].clip === 'Run');
  await page.waitForFunction(() => window.mimesh.studio.phase.peek().name === 'ready');
  assert.deepEqual(await page.evaluate(() => window.mimesh.studio.pipeline.pipeline.peek().value.source.poses), {
    clip: 'Run',
  });
  await page.selectOption('.clip-choice select', '*');
  await page.waitForFunction(() => window.mimesh.studio.session.peek().poses.list.at(-1).clip === 'Run');
  await page.waitForFunction(() => document.querySelector('.clip-choice select').value === '*');
  assert.equal(await page.evaluate(() => window.mimesh.studio.session.peek().poses.list[0].clip), 'Walk');
  await page.selectOption('.clip-choice select', 'Walk');
  await page.waitForFunction(() => window.mimesh.studio.session.peek().poses.list.at(-1).clip === 'Walk');
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('numbers of points stay when another is deleted', async () => {
  const page = await studio.open();
  const before = await pairs(page);
  await page.evaluate((id) => window.mimesh.studio.markers.edit({ op: 'delete', pair: id }), before[1].id);
  await saved(page);
  const numbers = (list) => list.map((one) => [one.id, one.number]);
  assert.deepEqual(numbers(await pairs(page)), numbers(before.filter((_, i) => i !== 1)));
  await page.evaluate(() => window.mimesh.studio.history.step(false));
  assert.deepEqual(numbers(await pairs(page)), numbers(before));
  await page.close();
});

// It names settings of the pipeline of the mock.
test('free values are YAML, and Tab moves on', { skip: !mocked }, async () => {
  const page = await studio.open();
  await page.click('#tab-stages');
  const field = '[data-path="output"]';
  await page.waitForSelector(field);
  assert.equal(await page.inputValue(field), '[out/camel.glb, out/report.html]');
  await page.fill(field, '[a.glb, { b: 1');
  await page.press(field, 'Tab');
  await page.waitForSelector('.field-problem:visible');
  assert.notEqual(await page.evaluate(() => document.activeElement.dataset.path), 'output');
  await page.fill(field, '[a.glb, b.html]');
  await page.press(field, 'Tab');
  await page.waitForFunction(() => document.querySelector('.yaml').value.includes('b.html'));
  assert.deepEqual(await page.evaluate(() => window.mimesh.studio.pipeline.pipeline.peek().value.output), [
    'a.glb',
    'b.html',
  ]);
  // The button that the focus had gone to is drawn anew, and has it again.
  assert.equal(await page.evaluate(() => document.activeElement.dataset.path), 'output:reset');
  const { width } = await page.locator(field).boundingBox();
  assert.ok(width > 250, `${width}`);
  // In the text Tab indents, and Escape lets the next one move on.
  await page.focus('.yaml');
  await page.keyboard.press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement.className), 'yaml');
  await page.keyboard.press('Escape');
  await page.keyboard.press('Tab');
  assert.notEqual(await page.evaluate(() => document.activeElement.className), 'yaml');
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('a run has sentences, its places are pointed at, and it is out of date after a change', {
  skip: !mocked,
}, async () => {
  const own = await serve({ resolution: 50 });
  const page = await openPage(studio.browser, own.url);
  await page.click('.run-control .primary');
  await page.waitForSelector('.total');
  assert.equal(await page.textContent('.total'), 'Look at 2 things.');
  assert.equal(await page.locator('.outdated:visible').count(), 0);
  // What is there already is replaced.
  assert.match(await page.getAttribute('.run-control .primary', 'title'), / and replaces /);
  const place = () => page.evaluate(() => window.mimesh.stage.pane('result').view.labels.find((one) => one.passive));
  await page.click('.faults-of-run .button');
  await atRest(page);
  assert.equal((await place()).text, 'here');
  assert.deepEqual(await page.evaluate(() => window.mimesh.studio.live.pose.peek()), { index: 6 });
  // The place fades, and does not come between a hand and the points.
  await page.waitForFunction(() => !window.mimesh.stage.pane('result').view.labels.some((one) => one.passive));
  await page.evaluate(() => window.mimesh.studio.pipeline.set(['output'], 'x.glb'));
  await page.waitForSelector('.outdated:visible');
  // Another clip would go into the files of this one.
  await page.selectOption('.clip-choice select', 'Run');
  await page.waitForFunction(() =>
    /^The next run replaces .*\.glb/.test(document.querySelector('.notice-text').textContent),
  );
  assert.deepEqual(page.errors, []);
  await page.close();
  await own.close();
});

test('one file for source and target is warned of', { skip: !mocked }, async () => {
  const empty = await serve({ resolution: 40, open: false });
  const page = await openPage(studio.browser, empty.url, { ready: false });
  await page.waitForSelector('.entry.mesh');
  await page.click('text=horse.glb');
  await page.click('.entry.mesh >> text=horse.glb');
  await page.waitForSelector('text=Source and target are the same file.');
  await page.close();
  await empty.close();
});

test('the timeline has a slider that can be scrubbed, and no control is cut off, on a small screen with Stages open', {
  skip: !mocked,
}, async () => {
  const page = await studio.open();
  await page.click('#tab-stages');
  await page.waitForSelector('.group');
  for (const [width, height] of [
    [1280, 720],
    [900, 700],
  ]) {
    await page.setViewportSize({ width, height });
    const slider = await page.locator('.timeline input').boundingBox();
    assert.ok(slider.width >= 160, `${slider.width} at ${width}`);
    const cut = await page.evaluate(() =>
      [...document.querySelectorAll('.views :is(button, select, input)')]
        .filter((one) => one.checkVisibility() && !one.closest('.popover'))
        .filter((one) => one.getBoundingClientRect().right > window.innerWidth)
        .map((one) => one.outerHTML),
    );
    assert.deepEqual(cut, []);
  }
  // Lines of the text that wrap keep their numbers beside them.
  await page.waitForFunction(
    () => document.querySelector('.gutter').offsetHeight <= document.querySelector('.yaml').scrollHeight,
  );
  assert.deepEqual(page.errors, []);
  await page.close();
});

test('after Escape a view turns about the middle of its mesh', async () => {
  const page = await studio.open();
  await page.keyboard.press('j');
  await atRest(page);
  await page.keyboard.press('Escape');
  const depth = () =>
    page.evaluate(() => {
      const { camera } = window.mimesh.stage.pane('source').view;
      return camera.position.length();
    });
  const before = await depth();
  await page.focus('.pane-source .pane-surface');
  for (let i = 0; i < 6; i++) await page.keyboard.press('ArrowRight');
  await page.waitForTimeout(300);
  // The eye keeps its distance from the middle.
  assert.ok(Math.abs((await depth()) - before) < 1e-6);
  await page.close();
});

test('a source with shapes and a clip goes from one to the other and back', { skip: !mocked }, async () => {
  const own = await serve({ resolution: 40, shapes: true });
  const page = await openPage(studio.browser, own.url);
  const box = '.clip-choice select';
  const options = () => page.locator('.clip-choice option').allTextContents();
  const are = (kind) => page.waitForFunction((k) => window.mimesh.studio.session.peek().poses.are === k, kind);
  assert.deepEqual(await options(), ['Shapes', 'Wave · 1.00 s, 24 frames']);
  assert.equal(await page.inputValue(box), '');
  await page.selectOption(box, 'Wave');
  await are('frames');
  await page.waitForFunction(() => document.querySelector('.clip-choice select').value === 'Wave');
  assert.deepEqual(await options(), ['Shapes', 'Wave · 1.00 s, 24 frames']);
  await page.selectOption(box, '');
  await are('shapes');
  assert.deepEqual(page.errors, []);
  await page.close();
  await own.close();
});

test('a view that joins linked cameras looks from their side, and all turn alike', async () => {
  const page = await studio.open();
  await page.keyboard.press('2');
  await atRest(page);
  await page.keyboard.press('v');
  const sides = () =>
    page.evaluate(() =>
      window.mimesh.stage.panes
        .peek()
        .map(({ view }) => [view.orbit.yaw, view.orbit.pitch].map((x) => x.toFixed(6)).join()),
    );
  await page.waitForFunction(() => window.mimesh.stage.panes.peek().length === 3);
  assert.deepEqual(new Set(await sides()).size, 1);
  // Views that were turned alone line up when they are linked.
  await page.keyboard.press('l');
  await page.focus('.pane-rest .pane-surface');
  for (let i = 0; i < 4; i++) await page.keyboard.press('ArrowRight');
  assert.deepEqual(new Set(await sides()).size, 2);
  await page.keyboard.press('l');
  await page.keyboard.press('ArrowUp');
  await atRest(page);
  assert.deepEqual(new Set(await sides()).size, 1);
  await page.keyboard.press('v');
  await page.close();
});
