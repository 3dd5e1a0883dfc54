import type { Pair } from '../protocol/types.ts';
import { readable } from '../ui/words.ts';

/** What a person has to do about a pair. */
export type Need = 'partner' | 'doubtful' | 'proposed' | 'none';

/** In percent, as people read it: two pairs that read `50 % sure` look alike. */
const DOUBTFUL_BELOW = 50;

export function needOf(pair: Pair): Need {
  if (pair.status === 'skipped') return 'none';
  if (!pair.source || !pair.target) return 'partner';
  if (pair.status === 'confirmed') return 'none';
  return percentOf(pair) < DOUBTFUL_BELOW ? 'doubtful' : 'proposed';
}

/** How sure a proposal is, in whole percent. */
export function percentOf(pair: Pair): number {
  return Math.round((pair.confidence ?? 0) * 100);
}

/** Pairs that need a person first, the least sure before others; then confirmed ones in their order, then skipped ones. */
export function doubtfulFirst(pairs: readonly Pair[]): Pair[] {
  return [...pairs].sort((a, b) => rank(a) - rank(b) || sureness(a) - sureness(b) || a.number - b.number);
}

function rank(pair: Pair): number {
  if (pair.status === 'skipped') return 3;
  const need = needOf(pair);
  if (need === 'partner') return 0;
  return need === 'none' ? 2 : 1;
}

function sureness(pair: Pair): number {
  return pair.status === 'proposed' ? (pair.confidence ?? 0) : 1;
}

export function matches(pair: Pair, search: string): boolean {
  const words = search.trim().toLowerCase();
  if (!words) return true;
  const text = `${pair.number} ${pair.name ?? ''} ${pairTitle(pair)} ${pair.note ?? ''} ${pair.status}`.toLowerCase();
  return words.split(/\s+/).every((word) => text.includes(word));
}

export function pairTitle(pair: Pair): string {
  return pair.name === null ? `Pair ${pair.number}` : readable(pair.name);
}

/** The pair before or after another in a list, round the end. */
export function neighbour(list: readonly Pair[], id: number | null, step: 1 | -1): Pair | null {
  if (list.length === 0) return null;
  const index = list.findIndex((pair) => pair.id === id);
  if (index < 0) return step > 0 ? list[0] : list[list.length - 1];
  return list[(index + step + list.length) % list.length];
}
