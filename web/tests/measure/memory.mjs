// Memory while the timeline is scrubbed without a pause.
import { readdir, readFile } from 'node:fs/promises';

/** Scrubs for some seconds; megabytes at each of the times, after a collection of garbage. */
export async function scrub(page, server, secondsOfReadings) {
  const session = await page.context().newCDPSession(page);
  const slider = await page.locator('.timeline input').boundingBox();
  const y = slider.y + slider.height / 2;
  const [left, width] = [slider.x + 8, slider.width - 16];
  const start = performance.now();
  const readings = [];
  let moves = 0;
  await page.mouse.move(left, y);
  await page.mouse.down();
  for (const due of secondsOfReadings) {
    while (performance.now() - start < due * 1000) {
      moves += 1;
      await page.mouse.move(left + width * (0.5 - 0.5 * Math.cos(moves / 20)), y);
      // As fast as frames come, and no faster than a hand.
      await page.waitForTimeout(16);
    }
    readings.push({ seconds: due, moves, ...(await memory(session, server)) });
  }
  await page.mouse.up();
  return readings;
}

async function memory(session, server) {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize, backingStorageSize } = await session.send('Runtime.getHeapUsage');
  return {
    script: megabytes(usedSize),
    buffers: megabytes(backingStorageSize ?? 0),
    browser: await resident((words) => words.includes('--type=renderer') || words.includes('--type=gpu-process')),
    server: server.pid ? await resident((_, pid) => pid === server.pid) : null,
  };
}

/** The resident megabytes of all processes for which `test` holds of their words and number. */
async function resident(test) {
  let sum = 0;
  for (const name of await readdir('/proc')) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const words = (await readFile(`/proc/${name}/cmdline`, 'utf8')).split('\0');
      if (!test(words, Number(name))) continue;
      const status = await readFile(`/proc/${name}/status`, 'utf8');
      sum += Number(/VmRSS:\s+(\d+)/.exec(status)?.[1] ?? 0) * 1024;
    } catch {
      // It has ended meanwhile.
    }
  }
  return megabytes(sum);
}

function megabytes(bytes) {
  return Math.round(bytes / 1e5) / 10;
}
