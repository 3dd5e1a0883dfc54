const SAMPLES = 3;
/** The first pictures of a scene take longer: shaders are compiled, buffers are filled. */
const SKIPPED = 3;
const SLOW_MILLISECONDS = 40;

/** Finds out whether the machine turns the present meshes smoothly, from a few pictures that are timed to their end. */
export class Pace {
  private samples: number[] = [];
  private scene = -1;
  private skipped = 0;

  get slow(): boolean {
    return this.samples.length === SAMPLES && [...this.samples].sort((a, b) => a - b)[1] > SLOW_MILLISECONDS;
  }

  /** Whether the next picture of a scene should be timed. */
  wants(scene: number): boolean {
    if (scene !== this.scene) {
      this.scene = scene;
      this.samples = [];
      this.skipped = 0;
    }
    this.skipped += 1;
    return this.skipped > SKIPPED && this.samples.length < SAMPLES;
  }

  add(milliseconds: number): void {
    this.samples.push(milliseconds);
  }
}
