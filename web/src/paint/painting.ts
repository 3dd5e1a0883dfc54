import type { MeshFacts, Session, Side } from '../protocol/types.ts';
import { signal } from '../ui/signal.ts';
import { Draft, type PaintKind, type PaintState } from './draft.ts';

/** Something that was done to a draft. */
interface Step {
  draft: Draft;
  kind: PaintKind;
  title: string;
  /** Its place among the steps of points and settings: between that number and the next. */
  after: number;
  /** The other state: the one before while the step is done, the one after while it is undone. */
  state: PaintState;
}

/** The steps of points and settings, which the server numbers. */
export interface ServerSteps {
  /** The number of the last one that is done. */
  done: number;
  /** The highest number that was seen. */
  highest: number;
}

const MOST_STEPS = 50;

/**
 * What is painted, with its history. Drafts belong to meshes: they outlive another clip, and one that is left unsaved is there again when
 * its project is.
 */
export class Painting {
  readonly side = signal<Side>('target');
  readonly kind = signal<PaintKind>('weights');
  /** Rises with every change. */
  readonly version = signal(0);
  /** Says where the server's steps stand. */
  steps: () => ServerSteps = () => ({ done: 0, highest: 0 });
  private readonly drafts = new Map<string, Draft>();
  private present: Record<Side, Draft> = { source: new Draft('source', 0), target: new Draft('target', 0) };
  private past: Step[] = [];
  private future: Step[] = [];
  /** Steps of the server that were undone before a stroke, and which it ends: numbers above `from`, up to `to`. */
  private ended = { from: 0, to: 0 };

  /** Takes the drafts of the meshes of a project; returns the names of the files that were left with unsaved drafts. */
  open({ name, source, target }: Session): string[] {
    const before = Object.values(this.present);
    this.present = { source: this.draftOf('source', name, source), target: this.draftOf('target', name, target) };
    const left = before.filter((draft) => !Object.values(this.present).includes(draft) && isUnsaved(draft));
    const files = [...this.drafts].filter(([, draft]) => left.includes(draft)).map(([key]) => JSON.parse(key)[2]);
    // Drafts without strokes need not be kept.
    for (const [key, draft] of this.drafts)
      if (!isUnsaved(draft) && this.present[draft.side] !== draft) this.drafts.delete(key);
    this.changed();
    return files;
  }

  draft(): Draft {
    return this.present[this.side.value];
  }

  /** The draft of the side that is not shown, too. */
  draftOn(side: Side): Draft {
    return this.present[side];
  }

  /** Whether anything is painted that would be lost with the page. */
  get hasUnsaved(): boolean {
    void this.version.value;
    return [...this.drafts.values()].some(isUnsaved);
  }

  /** Begins a step of undo: everything until the next one. */
  begin(title: string, kind = this.kind.peek(), draft = this.present[this.side.peek()]): void {
    const { done, highest } = this.steps();
    if (highest > done) this.ended = { from: done, to: highest };
    this.past = [...this.past, { draft, kind, title, after: done, state: draft.state(kind) }].slice(-MOST_STEPS);
    this.future = [];
    this.changed();
  }

  changed(): void {
    this.version.value = this.version.peek() + 1;
  }

  /** The step that was begun was no step. */
  cancel(): void {
    const step = this.past.pop();
    if (step) step.draft.restore(step.state);
    this.changed();
  }

  /** What would be undone or done again, and its place among the server's steps. */
  due(redo: boolean): { title: string; order: number } | null {
    void this.version.value;
    const step = (redo ? this.future : this.past).findLast((one) => this.isPresent(one));
    return step ? { title: step.title, order: step.after + 0.5 } : null;
  }

  /** Takes back the last step, or does it again, and shows where. */
  step(redo: boolean): void {
    const [from, to] = redo ? [this.future, this.past] : [this.past, this.future];
    const index = from.findLastIndex((one) => this.isPresent(one));
    if (index < 0) return;
    const [step] = from.splice(index, 1);
    to.push({ ...step, state: step.draft.state(step.kind) });
    step.draft.restore(step.state);
    this.side.value = step.draft.side;
    this.kind.value = step.kind;
    this.changed();
  }

  /** Whether a step of the server cannot be done again, since something was painted after it was undone. */
  hasEnded(order: number): boolean {
    void this.version.value;
    return order > this.ended.from && order <= this.ended.to;
  }

  /** The server did a new step: what was undone before it is not done again. */
  endFuture(): void {
    if (this.future.length === 0) return;
    this.future = [];
    this.changed();
  }

  /** A server that was started anew counts its steps anew: all strokes are after those that it knows. */
  rebase(): void {
    const { done } = this.steps();
    const clamp = (step: Step) => ({ ...step, after: Math.min(step.after, done) });
    this.past = this.past.map(clamp);
    this.future = this.future.map(clamp);
    this.ended = { from: 0, to: 0 };
    this.changed();
  }

  private isPresent({ draft }: Step): boolean {
    return this.present[draft.side] === draft;
  }

  private draftOf(side: Side, name: string | null, facts: MeshFacts | null): Draft {
    const key = JSON.stringify([side, name, facts?.file ?? 'generated', facts]);
    const draft = this.drafts.get(key) ?? new Draft(side, facts?.vertices ?? 0);
    this.drafts.set(key, draft);
    return draft;
  }
}

function isUnsaved(draft: Draft): boolean {
  return !draft.isSaved('weights') || !draft.isSaved('components');
}
