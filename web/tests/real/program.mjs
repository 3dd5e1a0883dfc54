// The program: commands that it runs, and the server of `mimesh studio`.
import { execFile, spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdir } from 'node:fs/promises';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

/** The program at MIMESH, else the one that cargo builds. */
export const program = process.env.MIMESH || fileURLToPath(new URL('../../../target/release/mimesh', import.meta.url));

/** What the program keeps beside its outputs lies hidden in the folder itself: an interrupted server leaves its own folder behind. */
async function environment(folder) {
  const [cache, temporary] = [join(folder, '.cache'), join(folder, '.temporary')];
  await mkdir(temporary, { recursive: true });
  return { ...process.env, MIMESH_CACHE: cache, TMPDIR: temporary };
}

/** Runs a command of the program to its end; fails if the program does. */
export async function command(folder, ...words) {
  return promisify(execFile)(program, words, { cwd: folder, env: await environment(folder) });
}

/** Starts `mimesh studio` in a folder; resolves when it has printed its address. */
export async function startStudio(folder, ...words) {
  const child = spawn(program, ['studio', '--no-open', ...words], {
    cwd: folder,
    env: await environment(folder),
    stdio: ['ignore', 'pipe', 'inherit'],
  });
  const ended = once(child, 'exit').then(([code, signal]) => code ?? signal);
  const lines = createInterface({ input: child.stdout });
  const printed = new Promise((resolve) => {
    lines.on('line', (line) => line.startsWith('http') && resolve(line.trim()));
  });
  const failed = ended.then((status) => {
    throw new Error(`mimesh studio ended with ${status} before it printed an address`);
  });
  const url = await Promise.race([printed, failed]);
  failed.catch(() => {});
  return {
    url,
    pid: child.pid,
    /** Interrupts the program as Ctrl C does, and gives its exit status. */
    stop: () => {
      child.kill('SIGINT');
      return ended;
    },
  };
}
