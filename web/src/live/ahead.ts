import type { Ahead } from '../protocol/types.ts';

/** The state that frames belong to. */
export interface Present {
  revision: number;
  pipeline: number;
  scalar: string | null;
}

/** Whether frames that were computed ahead are of the present points, settings and colours. */
function isOf(ahead: Ahead | null, present: Present): ahead is Ahead {
  return (
    ahead !== null &&
    ahead.revision === present.revision &&
    ahead.pipeline === present.pipeline &&
    ahead.scalar === present.scalar
  );
}

/** How far apart the frames lie whose results can be played; null while they are not all there. */
export function playableStep(ahead: Ahead | null, present: Present): number | null {
  return isOf(ahead, present) && ahead.error === null && ahead.count > 0 && ahead.done === ahead.count
    ? ahead.step
    : null;
}

/** What is still to be done before results can be played, e.g. "preparing the result: 12 of 30 frames". */
export function preparation(ahead: Ahead | null, present: Present): string {
  if (!isOf(ahead, present)) return 'the result is being prepared';
  // What is being checked will have a result.
  if (ahead.error?.code === 'not_found') return `no result yet: ${ahead.error.message}`;
  if (ahead.error) return `no result: ${ahead.error.message}`;
  return `preparing the result: ${ahead.done} of ${ahead.count} frames`;
}

/** The frame that is played for a wanted one, where only some were computed. */
export function nearestFrame(frame: number, step: number): number {
  return frame - (frame % step);
}
