import type { Level } from '../protocol/types.ts';
import { h } from './dom.ts';
import { icon } from './icons.ts';

const WORDS: Record<Level, string> = { good: 'good', doubtful: 'doubtful', bad: 'bad', broken_gate: 'over the limit' };

export function verdict(level: Level): HTMLElement {
  return h('span', { class: `verdict ${level}` }, icon(level === 'good' ? 'check' : 'warning'), WORDS[level]);
}
