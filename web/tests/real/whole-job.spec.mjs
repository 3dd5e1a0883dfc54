// The whole job by real mouse and keyboard on the real program: two files become motion that `mimesh run` gives again, byte by byte.
import assert from 'node:assert/strict';
import { mkdir, mkdtemp, readFile, rename, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { atRest, launch, loaded, openPage, pairs, saved } from '../browser.mjs';
import { freePlace, pointOnScreen } from '../places.mjs';
import { command, startStudio } from './program.mjs';
import { makeAnimals } from './samples.mjs';

/** Takes a picture of each state if MIMESH_PICTURES names a folder. */
const pictures = process.env.MIMESH_PICTURES;
let taken = 0;
let failed = false;
let folder;
let browser;
let studio;
let page;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'mimesh-job-'));
  await Promise.all([mkdir(join(folder, 'empty')), makeAnimals(join(folder, 'animals'), { horse: 28, camel: 30 })]);
  if (pictures) await mkdir(pictures, { recursive: true });
  [browser, studio] = await Promise.all([launch(), startStudio(join(folder, 'empty'), '--root', '../animals')]);
});

after(async () => {
  await browser?.close();
  await studio?.stop();
  if (folder) await rm(folder, { recursive: true });
});

step('two files are opened by the file browser of the page', async () => {
  page = await openPage(browser, studio.url, { ready: false });
  await page.waitForSelector('.browser .empty');
  await picture('start');
  await page.click('.roots >> text=animals');
  await page.click('.entry.mesh >> text=horse.glb');
  await page.click('.entry.mesh >> text=camel.obj');
  await picture('chosen');
  await page.click('.slots > .button');
  await loaded(page);
});

step('points are proposed, and j goes from the least sure to surer ones', async () => {
  await page.waitForFunction(() => {
    const { jobs, markers } = window.mimesh.studio;
    const proposed = markers.pairs.peek().filter((pair) => pair.status === 'proposed');
    return proposed.length >= 6 && jobs.peek().every((job) => job.state !== 'running');
  });
  await resultIsThere();
  await picture('proposed');
  const seen = [];
  for (let i = 0; i < 3; i++) {
    await page.keyboard.press('j');
    await page.waitForFunction((before) => window.mimesh.studio.selected.peek() !== before, seen.at(-1)?.id ?? null);
    seen.push(await selectedPair());
    await atRest(page);
  }
  assert.equal(new Set(seen.map((pair) => pair.id)).size, 3);
  assert.ok(seen.every((pair, i) => pair.confidence >= (seen[i - 1]?.confidence ?? 0)));
  await picture('looked-at');
  await wholeView();
});

step('three points are corrected: two by a drag, one by a click', async () => {
  const before = await pairs(page);
  const [first, second, third] = before.filter((pair) => pair.source && pair.target);
  await drag('result', first.id, [14, 4]);
  await drag('source', second.id, [-10, 6]);
  await select(third.id);
  const place = await freePlace(page, 'result');
  await page.mouse.click(place.x, place.y);
  await changed(third, 'target');
  await saved(page);
  await page.keyboard.press('Escape');
  await resultIsThere();
  await picture('corrected');
  const now = await onServer();
  assert.deepEqual(
    now.filter((pair, i) => !same(pair, before[i])).map((pair) => [pair.id, pair.status]),
    [first, second, third].map((pair) => [pair.id, 'confirmed']),
  );
});

step('two corrections are undone, and a reload has all of it', async () => {
  const [first, second, third] = await onServer();
  for (const [pair, side] of [
    [third, 'target'],
    [second, 'source'],
  ]) {
    await page.keyboard.press('Control+z');
    await changed(pair, side);
  }
  const undone = await onServer();
  assert.deepEqual(
    undone.slice(0, 3).map((pair) => pair.status),
    ['confirmed', 'proposed', 'proposed'],
  );
  assert.deepEqual(undone[0].target, first.target);
  await page.reload();
  await loaded(page);
  assert.deepEqual(await pairs(page), undone);
  await resultIsThere();
  await picture('reloaded');
});

step('a new pair on one side gets its partner by the mirror', async () => {
  const before = await pairs(page);
  await page.keyboard.press('2');
  await atRest(page);
  for (const pane of ['source', 'result']) {
    const place = await freePlace(page, pane);
    await page.mouse.click(place.x, place.y);
  }
  await saved(page);
  assert.equal((await onServer()).length, before.length + 1);
  await page.keyboard.press('m');
  await page.waitForSelector('dialog[open]');
  await picture('mirror');
  await page.click('dialog .primary');
  await page.waitForFunction((n) => window.mimesh.studio.markers.pairs.peek().length >= n, before.length + 2);
  await saved(page);
  const added = (await onServer()).slice(before.length);
  assert.equal(added[1].origin, 'mirrored');
  await resultIsThere();
  await picture('mirrored');
});

step('the timeline is scrubbed by the mouse, and both meshes follow', async () => {
  const box = await page.locator('.timeline input').boundingBox();
  const y = box.y + box.height / 2;
  await page.mouse.move(box.x + 8, y);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(box.x + 8 + ((box.width - 16) * i) / 14, y);
  await page.mouse.up();
  await page.waitForFunction(() => {
    const { live } = window.mimesh.studio;
    const wanted = live.pose.peek()?.index;
    return wanted > 4 && [live.source, live.target].every((shown) => shown.peek().header.pose?.index === wanted);
  });
  await resultIsThere();
  await picture('scrubbed');
  await page.click('#tab-result');
  await page.selectOption('.result select', 'edge_stretch');
  await page.waitForSelector('.legend:visible');
  await picture('stretch');
});

step('a run writes its files, and all is saved', async () => {
  await page.click('.run-control .primary');
  await page.waitForFunction(() => window.mimesh.studio.jobs.peek().some((job) => job.kind === 'run'));
  await page.waitForFunction(() => {
    const job = window.mimesh.studio.jobs.peek().find((other) => other.kind === 'run');
    return job.state !== 'running';
  });
  assert.match(await page.textContent('.save-state'), /^Saved$/);
  const files = await page.locator('.files a').allTextContents();
  assert.deepEqual(files, ['camel-from-horse.glb', 'camel-from-horse.html', 'run.json']);
  await picture('done');
  assert.deepEqual(page.errors, []);
  await page.close();
});

step('mimesh run on the saved pipeline gives the same motion, byte by byte, and the same report', async () => {
  await studio.stop();
  const [animals, ofPage] = [join(folder, 'animals'), join(folder, 'of-page')];
  await mkdir(ofPage);
  for (const name of ['camel-from-horse.glb', 'camel-from-horse.html', 'run.json']) {
    await rename(join(animals, name), join(ofPage, name));
  }
  // The report names files as the command does, so it gets the whole path, as the studio has it. All is computed anew.
  await command(animals, 'run', '--no-cache', join(animals, 'camel-from-horse.yaml'));
  const read = (name) => Promise.all([ofPage, animals].map((where) => readFile(join(where, name))));
  const [motion, same] = await read('camel-from-horse.glb');
  assert.ok(motion.equals(same), 'camel-from-horse.glb differs');
  // The report tells how long each run took and how much memory it had, which no two runs have alike.
  const [report, sameReport] = (await read('camel-from-horse.html')).map((file) => withoutTimes(file.toString()));
  assert.ok(report === sameReport, 'camel-from-horse.html differs');
});

/** A part of the job; after one that fails, the others say nothing. */
function step(name, run) {
  test(name, { timeout: 60_000 }, async (context) => {
    if (failed) return context.skip('a part before it failed');
    failed = true;
    try {
      await run();
    } catch (error) {
      await picture('failed').catch(() => {});
      throw error;
    }
    failed = false;
  });
}

async function picture(name) {
  if (!pictures) return;
  taken += 1;
  await page.screenshot({ path: join(pictures, `${String(taken).padStart(2, '0')}-${name}.png`) });
}

/** The pairs that the server has, which are those on its disk. */
function onServer() {
  return page.evaluate(async () => (await (await fetch('/api/markers')).json()).pairs);
}

function selectedPair() {
  return page.evaluate(() => window.mimesh.studio.markers.pair(window.mimesh.studio.selected.peek()));
}

/** Waits for a picture of the pipeline's own result with every point and in the pose that is chosen. */
async function resultIsThere() {
  await page.waitForFunction(() => {
    const { live, markers, pipeline } = window.mimesh.studio;
    const header = live.target.peek()?.header;
    return (
      header?.channel === 'result' &&
      header.revision === markers.document.peek().revision &&
      header.pipeline === pipeline.pipeline.peek()?.revision &&
      JSON.stringify(header.pose) === JSON.stringify(live.pose.peek())
    );
  });
}

/** Lets go of what is selected, and shows both meshes as wholes. */
async function wholeView() {
  await page.keyboard.press('Escape');
  await page.keyboard.press('Home');
  await atRest(page);
}

async function select(id) {
  await page.click(`.pair[data-pair="${id}"]`);
  await page.waitForFunction((wanted) => window.mimesh.studio.selected.peek() === wanted, id);
  await atRest(page);
}

/** Drags the point of a pair by some pixels; its place is preview while the hand moves, and saved after it. */
async function drag(pane, id, [dx, dy]) {
  await select(id);
  const side = pane === 'source' ? 'source' : 'target';
  const before = await selectedPair();
  const { x, y } = await pointOnScreen(page, pane, id);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx, y + dy, { steps: 8 });
  await page.waitForFunction(() => window.mimesh.studio.live.target.peek().header.drag !== null);
  await picture(`dragged-${side}`);
  await page.mouse.up();
  await changed(before, side);
  await saved(page);
}

/** Waits until the server has another point for the pair. */
async function changed(pair, side) {
  const hasMoved = async () => {
    const now = (await onServer()).find((other) => other.id === pair.id);
    return JSON.stringify(now[side]) !== JSON.stringify(pair[side]);
  };
  // The predicate of `waitForFunction` may not be asynchronous: a promise counts as true.
  while (!(await hasMoved())) await page.waitForTimeout(20);
  await saved(page);
}

function same(a, b) {
  return JSON.stringify([a.source, a.target, a.status]) === JSON.stringify([b.source, b.target, b.status]);
}

function withoutTimes(report) {
  return report.replaceAll(/[\d.]+( s\b| MB\b|%")/g, '*$1');
}
