import type { Job } from '../protocol/types.ts';

/**
 * Whether `job` is news about the job that was known as `before`. The answer to who began a job may come after the event that says how it
 * ended, and a job that has ended never runs again.
 */
export function follows(job: Job, before: Job | undefined): boolean {
  return before === undefined || before.state === 'running' || job.state !== 'running';
}
