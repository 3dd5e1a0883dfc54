// node tests/mock/main.mjs [resolution] [--empty] [--shapes] [--port=N]
import { fileURLToPath } from 'node:url';
import { MockServer } from './server.mjs';

const words = process.argv.slice(2);
const port = Number(words.find((word) => word.startsWith('--port='))?.slice(7) ?? 8790);
const server = new MockServer({
  dist: fileURLToPath(new URL('../../dist', import.meta.url)),
  resolution: Number(words.find((word) => /^\d+$/.test(word)) ?? 60),
  open: !words.includes('--empty'),
  shapes: words.includes('--shapes'),
});
console.log(await server.listen(port));
