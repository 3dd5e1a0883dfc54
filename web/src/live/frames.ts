import type { FrameHeader } from '../protocol/types.ts';

export type Stamp = Pick<FrameHeader, 'look' | 'revision' | 'pipeline' | 'drag'>;

/**
 * Whether a frame of the target replaces the one on the screen. The preview is quick and the result is right: a preview gives way to the
 * result of the same state, and a result to the preview of a newer one.
 */
export function replaces(shown: (Stamp & { channel: string }) | null, next: Stamp & { channel: string }): boolean {
  if (!shown) return true;
  const age = compare(next, shown);
  if (age !== 0) return age > 0;
  if (next.drag !== null || shown.drag !== null) return next.channel === 'preview';
  return next.channel === 'result' || shown.channel === 'preview';
}

function compare(a: Stamp, b: Stamp): number {
  return a.pipeline - b.pipeline || a.revision - b.revision || a.look - b.look || dragOf(a, b) - dragOf(b, a);
}

/** A frame after the end of a drag belongs to the present state; it must not lose to the last frame of the drag. */
function dragOf(stamp: Stamp, other: Stamp): number {
  if (stamp.drag === null || other.drag === null) return 0;
  return stamp.drag;
}

/** The frame to show of a clip that began at 0 and is played round and round. */
export function frameAt(seconds: number, rate: number, count: number): number {
  if (count < 1) return 0;
  return ((Math.floor(seconds * rate + 1e-9) % count) + count) % count;
}
