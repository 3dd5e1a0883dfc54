/** Weights of vertices from 0 to 1. Pure. */
export class PaintedMask {
  readonly weights: Float32Array;

  constructor(count: number) {
    this.weights = new Float32Array(count);
  }

  /** Adds to a vertex at a relative distance from the middle of the brush, 0 to 1; below zero it takes away. */
  dab(vertex: number, distance: number, strength: number): void {
    this.weights[vertex] = clamp(this.weights[vertex] + strength * falloff(distance));
  }

  change(how: (weight: number) => number): void {
    for (let i = 0; i < this.weights.length; i++) this.weights[i] = clamp(how(this.weights[i]));
  }
}

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
