import { cloneOrbit, eyeDirection, FIELD_OF_VIEW, type Orbit, pan, turn, wholeOrbit, zoom } from '../viewer/orbit.ts';
import type { View } from '../viewer/view.ts';
import type { Viewer } from '../viewer/viewer.ts';

const RADIANS_PER_PIXEL = 0.008;
const DEGREE = Math.PI / 180;
/** Room around meshes that are seen whole. */
const MARGIN = 1.08;

/** The cameras of all views, which always look alike. */
export class Cameras {
  private readonly viewer: Viewer;
  private readonly views: readonly View[];
  private readonly first: Orbit;

  constructor(viewer: Viewer, views: readonly View[], [yaw, pitch]: [number, number]) {
    this.viewer = viewer;
    this.views = views;
    this.first = { ...wholeOrbit(), yaw: yaw * DEGREE, pitch: pitch * DEGREE };
    this.reset();
  }

  /** Chooses how far away the whole of meshes is seen, which lie about the origin. */
  fit(meshes: readonly Float32Array[]): void {
    const aspect = Math.min(
      ...this.views.map(({ element }) => element.clientWidth / Math.max(element.clientHeight, 1)),
    );
    const slope = Math.tan((FIELD_OF_VIEW / 2) * DEGREE);
    const [across, down] = aspect >= 1 ? [slope * aspect, slope] : [slope, slope / aspect];
    const { x, y, z } = eyeDirection(this.first);
    const flat = Math.max(Math.hypot(x, z), 1e-9);
    let distance = 0;
    for (const positions of meshes) {
      for (let i = 0; i < positions.length; i += 3) {
        const [px, py, pz] = [positions[i], positions[i + 1], positions[i + 2]];
        const right = (px * z - pz * x) / flat;
        const up = py * flat - ((px * x + pz * z) / flat) * y;
        const near = px * x + py * y + pz * z;
        distance = Math.max(distance, near + Math.abs(right) / across, near + Math.abs(up) / down);
      }
    }
    this.first.distance = (distance || 1) * MARGIN;
  }

  /** Takes all cameras to the side of the pictures at once. */
  reset(): void {
    for (const view of this.views) view.orbit = cloneOrbit(this.first);
    this.viewer.invalidate();
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
