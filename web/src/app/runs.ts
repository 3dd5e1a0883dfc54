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
  /** Another clip of the same meshes has another number. */
  private readonly keys = new Map<number, string>();

  constructor(studio: State) {
    this.studio = studio;
  }

  /** Notes of what a job is, as long as it runs. */
  note(job: Job): void {
    const project = job.project ?? this.studio.session.peek()?.project ?? null;
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

  private isOfPresent(job: Job): boolean {
    const session = this.studio.session.value;
    const project = job.project ?? this.of(job)?.project;
    if (project === undefined || session === null || session.project === null) return false;
    this.keys.set(session.project, keyOf(session));
    return project === session.project || this.keys.get(project) === keyOf(session);
  }

  private of(job: Job): RunOf | null {
    return job.result?.of ?? this.begun.get(job.id) ?? null;
  }
}

function keyOf({ name, source, target }: Session): string {
  return JSON.stringify([name, source, target]);
}
