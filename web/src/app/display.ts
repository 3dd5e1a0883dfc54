import type { Side } from '../protocol/types.ts';
import { effect, type Signal, signal } from '../ui/signal.ts';
import { readStored, writeStored } from '../ui/storage.ts';
import type { Up } from '../viewer/frame.ts';

export type TargetContent = 'result' | 'rest' | 'truth' | 'over_truth' | 'over_rest';

/** How meshes are shown; choices of taste outlive a reload. */
export const display = {
  wireframe: stored('wireframe', false),
  xray: stored('xray', false),
  linked: stored('linked', true),
  /** Whether the target at rest has a view of its own beside the result. */
  threeViews: stored('three-views', false),
  sourceAtRest: signal(false),
  target: signal<TargetContent>('result'),
  up: { source: signal<Up | null>(null), target: signal<Up | null>(null) } satisfies Record<Side, Signal<Up | null>>,
};

function stored(key: string, otherwise: boolean): Signal<boolean> {
  const result = signal(readStored(key, otherwise));
  effect(() => writeStored(key, result.value));
  return result;
}
