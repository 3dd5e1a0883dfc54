import type { Job, Session } from '../protocol/types.ts';

/** The state that a run is of. */
export interface RunOf {
  project: number;
  markers: number;
  pipeline: number;
}

interface State {
  session: { readonly value: Session | null; peek(): Session | null };
  jobs: { readonly value: Job[] };
  live: { revisions: { readonly value: Omit<RunOf, 'project'>; peek(): Omit<RunOf, 'project'> } };
}

/**
 * The runs of the project that is open; the server remembers jobs of all projects. A run that failed does not say of which points and
 * settings it was, so the page notes them as a job begins.
 */
export class Runs {
  private readonly studio: State;
  private readonly begun = new Map<number, RunOf>();

  constructor(studio: State) {
    this.studio = studio;
  }

  /** Notes of what a job is, as long as it runs. */
  note(job: Job): void {
    const project = this.studio.session.peek()?.project ?? null;
    if (job.state !== 'running' || this.begun.has(job.id) || project === null) return;
    this.begun.set(job.id, { project, ...this.studio.live.revisions.peek() });
  }

  /** The last run of the project that is open. */
  last(): Job | null {
    return this.studio.jobs.value.find((job) => job.kind === 'run' && this.isOfPresent(job)) ?? null;
  }

  /** Whether points or settings have changed since a run. */
  isOutdated(job: Job): boolean {
    const of = this.of(job);
    const { markers, pipeline } = this.studio.live.revisions.value;
    const project = this.studio.session.value?.project;
    return of !== null && (of.project !== project || of.markers !== markers || of.pipeline !== pipeline);
  }

  /** Another clip gives the project another number, but it was opened as the same. */
  private isOfPresent(job: Job): boolean {
    const opened = this.studio.session.value?.opened ?? null;
    return opened !== null && job.project === opened;
  }

  private of(job: Job): RunOf | null {
    return job.result?.of ?? this.begun.get(job.id) ?? null;
  }
}
