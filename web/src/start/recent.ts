import type { OpenRequest } from '../protocol/types.ts';
import { readStored, writeStored } from '../ui/storage.ts';

const MOST = 6;

export function recentProjects(): OpenRequest[] {
  return readStored<OpenRequest[]>('recent', []);
}

export function rememberRecent(what: OpenRequest): void {
  const same = JSON.stringify(what);
  const others = recentProjects().filter((other) => JSON.stringify(other) !== same);
  writeStored('recent', [what, ...others].slice(0, MOST));
}
