import type { Mask, Side } from '../protocol/types.ts';
import { PaintedMask } from './mask.ts';

export type PaintKind = 'weights' | 'components';

/** Weights of vertices, or the names of the components that are chosen. */
export type PaintState = Float32Array | ReadonlySet<string>;

interface Saved {
  file: Mask | null;
  state: PaintState;
}

/** What is painted on a mesh, and which files hold it. Pure. */
export class Draft {
  readonly side: Side;
  readonly mask: PaintedMask;
  components: ReadonlySet<string> = new Set();
  private readonly saved: Record<PaintKind, Saved>;

  constructor(side: Side, vertices: number) {
    this.side = side;
    this.mask = new PaintedMask(vertices);
    this.saved = { weights: this.nothing('weights'), components: this.nothing('components') };
  }

  /** A copy, which later strokes leave as it is. */
  state(kind: PaintKind): PaintState {
    return kind === 'weights' ? this.mask.weights.slice() : new Set(this.components);
  }

  restore(state: PaintState): void {
    if (state instanceof Float32Array) this.mask.weights.set(state);
    else this.components = state;
  }

  /** The file that holds what is painted, or held it before the last strokes. */
  file(kind: PaintKind): Mask | null {
    return this.saved[kind].file;
  }

  isSaved(kind: PaintKind): boolean {
    const { state } = this.saved[kind];
    return state instanceof Float32Array ? sameNumbers(state, this.mask.weights) : sameNames(state, this.components);
  }

  /** `state` is what the file holds; strokes that were made while it was written are not in it. */
  markSaved(file: Mask, state: PaintState): void {
    this.saved[file.kind] = { file, state };
  }

  /** The file is gone. */
  forget({ name, kind }: Mask): void {
    if (this.saved[kind].file?.name === name) this.saved[kind] = this.nothing(kind);
  }

  private nothing(kind: PaintKind): Saved {
    return { file: null, state: kind === 'weights' ? new Float32Array(this.mask.weights.length) : new Set() };
  }
}

function sameNumbers(a: Float32Array, b: Float32Array): boolean {
  return a.length === b.length && a.every((value, i) => value === b[i]);
}

function sameNames(a: ReadonlySet<string>, b: ReadonlySet<string>): boolean {
  return a.size === b.size && [...a].every((name) => b.has(name));
}
