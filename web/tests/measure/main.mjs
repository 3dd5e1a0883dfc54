// Times and memory of the page, for humans: node tests/measure/main.mjs [vertices of the target …] [--memory=SECONDS]
// On the mock, or on the program at MIMESH with animals that it makes.
import os from 'node:os';
import { launch } from '../browser.mjs';
import { mocked, serve } from '../servers.mjs';
import { dragAbout } from './drag.mjs';
import { scrub } from './memory.mjs';
import { turn, watchFirstPicture } from './pictures.mjs';

const words = process.argv.slice(2);
const sizes = words.map(Number).filter(Number.isFinite);
const seconds = Number(words.find((word) => word.startsWith('--memory='))?.slice(9) ?? 0);
const browser = await launch();
for (const vertices of sizes.length > 0 ? sizes : [8000, 50000]) {
  const server = await serve(optionsFor(vertices));
  console.log(JSON.stringify(await measure(server, seconds)));
  await server.close();
  if (process.env.MIMESH_STUDIO_URL) break;
}
await browser.close();

/** Vertices grow with the square of how fine a mesh is: 60 gives 7,000 with the program, 85 gives 8,000 with the mock. */
function optionsFor(vertices) {
  if (mocked) return { resolution: Math.round(85 * Math.sqrt(vertices / 8000)) };
  return { horse: 64, camel: Math.round(60 * Math.sqrt(vertices / 7000)) };
}

async function measure(server, secondsOfScrubbing) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  await page.addInitScript(watchFirstPicture);
  await page.goto(server.url);
  await page.waitForFunction(() => window.firstPicture && window.mimesh.studio.live.target.peek(), null, {
    timeout: 120_000,
  });
  const facts = await page.evaluate(() => {
    const { source, target } = window.mimesh.studio.session.peek();
    return {
      sourceVertices: source.vertices,
      targetVertices: target.vertices,
      triangles: source.triangles + target.triangles,
    };
  });
  const firstPicture = Math.round(await page.evaluate(() => window.firstPicture));
  await calm(page);
  const turning = summary(await page.evaluate(turn, 40));
  const { latencies, ofServer } = await dragAbout(page, 60);
  const memory = secondsOfScrubbing > 0 ? await scrub(page, server, [60, secondsOfScrubbing]) : undefined;
  await page.close();
  return {
    load: os.loadavg()[0],
    ...facts,
    firstPicture,
    turning,
    drag: summary(latencies),
    ofServer: summary(ofServer),
    memory,
  };
}

/** Waits until proposals and the first result are there, so that the server has nothing else to do. */
async function calm(page) {
  await page.waitForFunction(
    () => {
      const { jobs, live, markers } = window.mimesh.studio;
      const complete = markers.pairs.peek().filter((pair) => pair.source && pair.target);
      return (
        complete.length >= 3 &&
        jobs.peek().every((job) => job.state !== 'running') &&
        live.states.peek().result?.state === 'ready'
      );
    },
    null,
    { timeout: 300_000 },
  );
}

function summary(times) {
  const sorted = [...times].sort((a, b) => a - b);
  const at = (share) => Math.round(sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * share))]);
  return { count: sorted.length, median: at(0.5), p95: at(0.95) };
}
