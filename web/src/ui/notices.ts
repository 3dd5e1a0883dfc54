import { splitCommands } from './prose.ts';
import { signal } from './signal.ts';

type Level = 'info' | 'error';

export interface Notice {
  id: number;
  level: Level;
  text: string;
  hint: string | null;
  /** What it is about: a newer notice of the same topic takes its place, and it goes when the matter is settled. */
  topic: string | null;
  at: Date;
}

const INFO_MILLISECONDS = 6000;
const MOST = 20;
const MOST_EARLIER = 50;
/** What holds at present, the newest last. */
export const notices = signal<Notice[]>([]);
/** What was said before, the newest last. */
export const earlier = signal<Notice[]>([]);
/** Those that nobody can have read in full, or that somebody is reading: they stay until they are closed. */
const kept = new Set<number>();
let count = 0;

/** Reports something in the line of messages; errors stay until they are settled or dismissed. */
export function notify(
  text: string,
  hint: string | null = null,
  level: Level = 'info',
  topic: string | null = null,
): void {
  count += 1;
  const id = count;
  // The page can do itself what commands would.
  const notice = { id, level, text, hint: hint && (splitCommands(hint).page || null), topic, at: new Date() };
  drop((other) => other.text === text || (topic !== null && other.topic === topic));
  const all = [...notices.peek(), notice];
  notices.value = all.slice(-MOST);
  putAway(all.slice(0, -MOST));
  if (level === 'info') window.setTimeout(() => kept.has(id) || dismiss(id), INFO_MILLISECONDS);
}

/** The notice stays until it is closed. */
export function keep({ id }: Notice): void {
  kept.add(id);
}

/** What was wrong about a topic is so no more. */
export function settle(topic: string): void {
  drop((notice) => notice.topic === topic);
}

/** What failed before may do now; what was done stays done. */
export function settleErrors(topics: readonly string[]): void {
  drop((notice) => notice.level === 'error' && topics.includes(notice.topic ?? ''));
}

/** Nothing that was said holds any more. */
export function clearNotices(): void {
  drop(() => true);
}

export function dismiss(id: number): void {
  drop((notice) => notice.id === id);
}

/** Takes notices out of the line; they can be read again among the earlier ones. */
function drop(which: (notice: Notice) => boolean): void {
  const gone = notices.peek().filter(which);
  if (gone.length === 0) return;
  notices.value = notices.peek().filter((notice) => !gone.includes(notice));
  putAway(gone);
}

function putAway(gone: readonly Notice[]): void {
  if (gone.length === 0) return;
  for (const { id } of gone) kept.delete(id);
  const texts = new Set(gone.map((notice) => notice.text));
  const others = earlier.peek().filter((notice) => !texts.has(notice.text));
  earlier.value = [...others, ...gone].slice(-MOST_EARLIER);
}
