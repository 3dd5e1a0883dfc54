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
    browser: await resident(process.pid, /--type=(renderer|gpu-process)/),
    server: server.pid ? await resident(server.pid) : null,
  };
}

/** The resident megabytes of a process and all below it, or of those whose command fits. */
async function resident(root, command = /./) {
  const processes = new Map();
  for (const name of (await readdir('/proc')).filter((entry) => /^\d+$/.test(entry))) {
    try {
      const read = (what) => readFile(`/proc/${name}/${what}`, 'utf8');
      const [words, status] = await Promise.all([read('cmdline'), read('status')]);
      const number = (key) => Number(new RegExp(`${key}:\\s+(\\d+)`).exec(status)?.[1] ?? 0);
      processes.set(Number(name), { words, parent: number('PPid'), bytes: number('VmRSS') * 1024 });
    } catch {
      // It has ended meanwhile.
    }
  }
  const isBelow = (pid) => pid === root || (processes.has(pid) && isBelow(processes.get(pid).parent));
  const found = [...processes].filter(([pid, { words }]) => isBelow(pid) && command.test(words));
  return megabytes(found.reduce((sum, [, { bytes }]) => sum + bytes, 0));
}

function megabytes(bytes) {
  return Math.round(bytes / 1e5) / 10;
}
