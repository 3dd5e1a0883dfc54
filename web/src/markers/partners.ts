import type { Pair } from '../protocol/types.ts';
import { listed, readableIn } from '../ui/words.ts';
import { pairTitle } from './order.ts';

/** Which pairs got no partner by the mirror, and why. */
export function withoutPartner(
  left: readonly { pair: number; reason: string }[],
  find: (id: number) => Pair | null,
): string | null {
  const names = new Map<string, string[]>();
  for (const { pair, reason } of left) {
    const found = find(pair);
    names.set(reason, [...(names.get(reason) ?? []), found ? pairTitle(found) : 'a pair']);
  }
  if (names.size === 0) return null;
  const phrases = [...names].map(([reason, titles]) => `${listed(titles)} (${readableIn(reason)})`);
  return `Without a partner: ${phrases.join('; ')}.`;
}
