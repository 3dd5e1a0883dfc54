import type { Job, Pair } from '../protocol/types.ts';
import { notify } from '../ui/notices.ts';
import { counted } from '../ui/words.ts';

/**
 * Whether `job` is news about the job that was known as `before`. The answer to who began a job may come after the event that says how it
 * ended, and a job that has ended never runs again.
 */
export function follows(job: Job, before: Job | undefined): boolean {
  return before === undefined || before.state === 'running' || job.state !== 'running';
}

/** Says how many pairs a stage has proposed. */
export function tellProposals(pairs: readonly Pair[]): void {
  const { length } = pairs.filter((pair) => pair.status === 'proposed');
  const were = length === 1 ? 'was' : 'were';
  if (length > 0) notify(`${counted(length, 'pair')} ${were} proposed.`, 'Look at them with Next.', 'info', 'propose');
  else notify('No pair was proposed.', 'Click a place on the source, then on the target.', 'info', 'propose');
}
