const SAMPLES = 3;
const SLOW_MILLISECONDS = 40;

/** Finds out whether the machine turns the present meshes smoothly, from a few pictures that are timed to their end. */
export class Pace {
  private samples: number[] = [];
  private scene = -1;

  get slow(): boolean {
    return this.samples.length === SAMPLES && [...this.samples].sort((a, b) => a - b)[1] > SLOW_MILLISECONDS;
  }

  /** Whether the next picture of a scene should be timed. */
  wants(scene: number): boolean {
    if (scene !== this.scene) {
      this.scene = scene;
      this.samples = [];
    }
    return this.samples.length < SAMPLES;
  }

  add(milliseconds: number): void {
    this.samples.push(milliseconds);
  }
}
