import { cloneOrbit, type Orbit, pan, turn, wholeOrbit, zoom } from '../viewer/orbit.ts';
import type { View } from '../viewer/view.ts';
import type { Viewer } from '../viewer/viewer.ts';

const RADIANS_PER_PIXEL = 0.008;
const DEGREE = Math.PI / 180;

/** The cameras of all views, which always look alike. */
export class Cameras {
  private readonly viewer: Viewer;
  private readonly views: readonly View[];
  private readonly first: Orbit;

  constructor(viewer: Viewer, views: readonly View[], [yaw, pitch]: [number, number]) {
    this.viewer = viewer;
    this.views = views;
    this.first = { ...wholeOrbit(), yaw: yaw * DEGREE, pitch: pitch * DEGREE };
    for (const view of views) view.orbit = cloneOrbit(this.first);
  }

  /** Turns by pixels that a pointer moved. */
  turn(x: number, y: number): void {
    this.change((orbit) => turn(orbit, x * RADIANS_PER_PIXEL, y * RADIANS_PER_PIXEL));
  }

  /** Moves by pixels of a view. */
  pan(view: View, x: number, y: number): void {
    this.change((orbit, aspect) => pan(orbit, (2 * x) / view.width, (-2 * y) / view.height, aspect));
  }

  /** Comes nearer or goes away; what is at a pixel of `view` stays there. */
  zoom(view: View, factor: number, x = view.width / 2, y = view.height / 2): void {
    const [deviceX, deviceY] = view.toDevice(x, y);
    this.change((orbit, aspect) => zoom(orbit, factor, deviceX, deviceY, aspect));
  }

  /** Shows all of the meshes from the side of the pictures. */
  whole(): void {
    for (const view of this.views) view.flyTo(this.first, performance.now());
    this.viewer.invalidate(true);
  }

  private change(apply: (orbit: Orbit, aspect: number) => void): void {
    for (const view of this.views) {
      view.stopFlight();
      apply(view.orbit, view.aspect);
    }
    this.viewer.invalidate(true);
  }
}
