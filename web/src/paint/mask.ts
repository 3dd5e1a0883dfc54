/** Weights of vertices from 0 to 1, painted stroke by stroke. Pure. */
export class PaintedMask {
  readonly weights: Float32Array;
  private past: Float32Array[] = [];
  private future: Float32Array[] = [];

  constructor(count: number, weights?: Float32Array) {
    this.weights = weights ? weights.slice() : new Float32Array(count);
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  /** Everything until the next call is one step of undo. */
  beginStroke(): void {
    this.past.push(this.weights.slice());
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.future = [];
  }

  /** Adds to a vertex at a relative distance from the middle of the brush, 0 to 1; below zero it takes away. */
  dab(vertex: number, distance: number, strength: number): void {
    this.weights[vertex] = clamp(this.weights[vertex] + strength * falloff(distance));
  }

  change(how: (weight: number) => number): void {
    this.beginStroke();
    for (let i = 0; i < this.weights.length; i++) this.weights[i] = clamp(how(this.weights[i]));
  }

  undo(): void {
    this.step(this.past, this.future);
  }

  redo(): void {
    this.step(this.future, this.past);
  }

  private step(from: Float32Array[], to: Float32Array[]): void {
    const state = from.pop();
    if (!state) return;
    to.push(this.weights.slice());
    this.weights.set(state);
  }
}

const MOST_STEPS = 50;

/** 1 in the middle of the brush, 0 at its rim, with a soft edge at both. */
export function falloff(distance: number): number {
  if (distance >= 1) return 0;
  return (1 - distance * distance) ** 2;
}

function clamp(value: number): number {
  return Math.min(Math.max(value, 0), 1);
}

/** The names that masks have until a person gives another: each kind its own. */
export const USUAL_NAMES = { weights: 'weights', components: 'rigid' } as const;

/** Names of files must do on any system. */
export function maskNameProblem(name: string): string | null {
  if (!/^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$/.test(name))
    return 'Use letters, digits, _ and -, and begin with a letter or digit.';
  return null;
}
