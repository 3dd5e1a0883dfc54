// Times of the page, for humans: node tests/measure.mjs [resolution of the mock's meshes …]
import os from 'node:os';
import { launch } from './browser.mjs';
import { pointOnScreen } from './places.mjs';
import { serve } from './servers.mjs';

const resolutions = process.argv.slice(2).map(Number);
const browser = await launch();
for (const resolution of resolutions.length > 0 ? resolutions : [85, 215]) {
  const server = await serve({ resolution });
  console.log(JSON.stringify(await measure(server.url)));
  await server.close();
  if (!server.mock) break;
}
await browser.close();

async function measure(url) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  await page.addInitScript(watchFirstPicture);
  await page.goto(url);
  await page.waitForFunction(() => window.firstPicture && window.mimesh.studio.live.target.peek());
  const facts = await page.evaluate(() => {
    const { source, target } = window.mimesh.studio.session.peek();
    return {
      vertices: source.vertices + target.vertices,
      targetVertices: target.vertices,
      triangles: source.triangles + target.triangles,
    };
  });
  const firstPicture = await page.evaluate(() => window.firstPicture);
  await page.waitForTimeout(1500);
  const turning = await page.evaluate(turn, 40);
  const drag = await dragAbout(page, 60);
  await page.close();
  return {
    load: os.loadavg()[0],
    ...facts,
    firstPicture: Math.round(firstPicture),
    turning: summary(turning),
    drag: summary(drag),
  };
}

/** Waits for the first picture with both meshes to be done, which reading a pixel does. */
function watchFirstPicture() {
  const timer = setInterval(() => {
    const { studio, stage } = window.mimesh ?? {};
    if (!studio?.meshes.peek()) return;
    clearInterval(timer);
    stage.viewer.onFrame = () => {
      if (!stage.panes.peek().every((pane) => pane.surface) || studio.phase.peek().name !== 'ready') return;
      stage.viewer.onFrame = null;
      const gl = stage.viewer.canvas.getContext('webgl2');
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      window.firstPicture = performance.now();
    };
    stage.viewer.invalidate();
  }, 5);
}

/** Milliseconds of pictures while the view is turned, each timed to its end. */
async function turn(count) {
  const { stage } = window.mimesh;
  const gl = stage.viewer.canvas.getContext('webgl2');
  const pane = stage.panes.peek()[0];
  const times = [];
  for (let i = 0; i < count; i++) {
    const start = performance.now();
    await new Promise((resolve) => {
      stage.viewer.onFrame = () => {
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        resolve();
      };
      stage.camera.turn(pane, 4, 0);
    });
    times.push(performance.now() - start);
  }
  stage.viewer.onFrame = null;
  return times;
}

/** Milliseconds from a move of the mouse to the end of the picture of the target that it made. */
async function dragAbout(page, count) {
  const id = await page.evaluate(
    () => window.mimesh.studio.markers.pairs.peek().find((pair) => pair.source && pair.target).id,
  );
  const { x, y } = await pointOnScreen(page, 'result', id);
  await page.evaluate(() => {
    const { studio, stage } = window.mimesh;
    const gl = stage.viewer.canvas.getContext('webgl2');
    window.latencies = [];
    let moved = null;
    let due = null;
    document.addEventListener(
      'pointermove',
      (event) => {
        moved ??= { time: event.timeStamp, drag: studio.live.target.peek().header.drag ?? 0 };
      },
      true,
    );
    const receive = studio.live.receive.bind(studio.live);
    studio.live.receive = (frame) => {
      receive(frame);
      if (moved && frame.header.drag !== null && frame.header.drag > moved.drag) {
        due = moved.time;
        moved = null;
      }
    };
    stage.viewer.onFrame = () => {
      if (due === null) return;
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      window.latencies.push(performance.now() - due);
      due = null;
    };
  });
  const body = await page.evaluate(middleOfMesh);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= count; i++) {
    await page.mouse.move(body.x + 12 * Math.sin(i / 5), body.y + 8 * Math.cos(i / 5));
    await page.waitForTimeout(60);
  }
  await page.mouse.up();
  return page.evaluate(() => window.latencies);
}

/** A place of the target that has mesh all around it. */
function middleOfMesh() {
  const pane = window.mimesh.stage.panes.peek().at(-1);
  const box = pane.surfaceElement.getBoundingClientRect();
  const around = [-16, 0, 16];
  for (let y = box.height / 2; y > 0; y -= 8) {
    for (let x = box.width / 2; x < box.width; x += 8) {
      if (around.every((dx) => around.every((dy) => pane.pick(x + dx, y + dy))))
        return { x: box.left + x, y: box.top + y };
    }
  }
  throw new Error('no place');
}

function summary(times) {
  const sorted = [...times].sort((a, b) => a - b);
  const at = (share) => Math.round(sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * share))]);
  return { count: sorted.length, median: at(0.5), p95: at(0.95) };
}
