// What the pages of a test talk to: the mock, the program at MIMESH with samples of its own, or a server at MIMESH_STUDIO_URL.
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { MockServer } from './mock/server.mjs';
import { startStudio } from './real/program.mjs';
import { makeAnimals } from './real/samples.mjs';

/** Whether pages talk to the mock, which tests can look into and whose project they know. */
export const mocked = !process.env.MIMESH_STUDIO_URL && !process.env.MIMESH;

/** The address of a server and what ends it. The options are those of the mock, or how fine the animals of the program are. */
export async function serve(options = {}) {
  if (process.env.MIMESH_STUDIO_URL) return { url: process.env.MIMESH_STUDIO_URL, mock: null, close: async () => {} };
  if (process.env.MIMESH) return serveSamples(options);
  const mock = new MockServer({ dist: fileURLToPath(new URL('../dist', import.meta.url)), ...options });
  return { url: await mock.listen(), mock, close: () => mock.close() };
}

async function serveSamples({ horse = 24, camel = 30 }) {
  const folder = await mkdtemp(join(tmpdir(), 'mimesh-studio-'));
  await makeAnimals(folder, { horse, camel });
  const studio = await startStudio(folder, 'horse.glb', 'camel.obj');
  const close = async () => {
    await studio.stop();
    await rm(folder, { recursive: true });
  };
  return { url: studio.url, pid: studio.pid, mock: null, close };
}
