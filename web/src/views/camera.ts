import { Vector3 } from 'three';
import { display } from '../app/display.ts';
import { frameOf } from '../viewer/frame.ts';
import { cloneOrbit, facing, MAX_DISTANCE, type Orbit, pan, turnAbout, wholeOrbit, zoom } from '../viewer/orbit.ts';
import type { Viewer } from '../viewer/viewer.ts';
import type { Pane } from './pane.ts';
import type { PaneCamera } from './pointer.ts';

const RADIANS_PER_PIXEL = 0.008;
const NEAR = 0.8;

/** Moves the cameras of the panes: all alike while they are linked. */
export class StageCamera implements PaneCamera {
  private readonly viewer: Viewer;
  private readonly panes: () => readonly Pane[];
  /** What the views look at. */
  private focus = new Map<Pane, Vector3>();
  private holds = () => false;

  constructor(viewer: Viewer, panes: () => readonly Pane[]) {
    this.viewer = viewer;
    this.panes = panes;
  }

  turn(pane: Pane, x: number, y: number): void {
    this.change(pane, (orbit, _, turned) =>
      turnAbout(orbit, this.pivot(turned), x * RADIANS_PER_PIXEL, y * RADIANS_PER_PIXEL),
    );
  }

  pan(pane: Pane, x: number, y: number): void {
    const { width, height } = pane.view;
    this.change(pane, (orbit, aspect) => pan(orbit, (2 * x) / width, (-2 * y) / height, aspect));
  }

  zoom(pane: Pane, factor: number, x: number, y: number): void {
    const [deviceX, deviceY] = pane.view.toDevice(x, y);
    this.change(pane, (orbit, aspect) => zoom(orbit, factor, deviceX, deviceY, aspect));
  }

  /** Turns all cameras to the side of one; what they look at stays. */
  link(pane: Pane): void {
    const { yaw, pitch } = pane.view.goal;
    for (const { view } of this.panes()) {
      if (view.goal.yaw !== yaw || view.goal.pitch !== pitch)
        view.flyTo({ ...cloneOrbit(view.goal), yaw, pitch }, performance.now());
    }
    this.viewer.invalidate(true);
  }

  /** A view that comes looks as another one of its mesh does, or from the same side. */
  join(pane: Pane, others: readonly Pane[]): void {
    const alike = others.find((other) => other.side === pane.side);
    const { yaw, pitch } = (alike ?? others[0]).view.goal;
    pane.view.jumpTo(alike ? alike.view.goal : { ...pane.view.orbit, yaw, pitch });
  }

  /** The whole mesh, from the side that a person looked from, or from another one. */
  whole(yaw?: number, pitch?: number): void {
    this.letGo();
    for (const pane of this.panes()) {
      const { orbit } = pane.view;
      const goal: Orbit = { ...wholeOf(pane), yaw: yaw ?? orbit.yaw, pitch: pitch ?? orbit.pitch };
      pane.view.flyTo(goal, performance.now());
    }
    this.viewer.invalidate(true);
  }

  /** Views turn about the middle of their meshes again. */
  letGo(): void {
    this.focus.clear();
  }

  /**
   * Brings each pane to its place of a point. Linked panes keep one direction, that of the first place. Views turn about their places as
   * long as `holds` is true.
   */
  flyTo(places: Map<Pane, { position: Vector3; normal: Vector3 }>, holds: () => boolean): void {
    this.focus = new Map([...places].map(([pane, { position }]) => [pane, position.clone()]));
    this.holds = holds;
    let direction: Orbit | null = null;
    for (const [pane, { position, normal }] of places) {
      const goal = facing(position, normal, NEAR);
      if (direction && display.linked.peek()) {
        goal.yaw = direction.yaw;
        goal.pitch = direction.pitch;
      }
      direction ??= goal;
      pane.view.flyTo(goal, performance.now());
    }
    if (direction && display.linked.peek()) this.follow(direction, places);
    this.viewer.invalidate(true);
  }

  /** Linked panes that have no place to fly to see their whole mesh from the same side. */
  private follow({ yaw, pitch }: Orbit, places: Map<Pane, unknown>): void {
    for (const pane of this.panes()) {
      if (!places.has(pane)) pane.view.flyTo({ ...wholeOf(pane), yaw, pitch }, performance.now());
    }
  }

  /** Other meshes are seen whole, from the usual side. */
  reset(): void {
    this.letGo();
    for (const pane of this.panes()) pane.view.jumpTo(wholeOrbit());
    this.viewer.invalidate(true);
  }

  /** The middle of the unit frame is that of the mesh. */
  private pivot(pane: Pane): Vector3 {
    return (this.holds() && this.focus.get(pane)) || new Vector3();
  }

  private change(pane: Pane, apply: (orbit: Orbit, aspect: number, pane: Pane) => void): void {
    const changed = display.linked.peek() ? this.panes() : [pane];
    const { yaw, pitch } = pane.view.orbit;
    for (const one of changed) {
      one.view.stopFlight();
      // A flight that was cut short leaves linked views on different sides.
      const { orbit } = one.view;
      if (orbit.yaw !== yaw || orbit.pitch !== pitch)
        turnAbout(orbit, this.pivot(one), orbit.yaw - yaw, pitch - orbit.pitch);
      apply(one.view.orbit, one.view.aspect, one);
    }
    this.viewer.invalidate(true);
  }
}

/** Sees all of the mesh as it is now: a pose may be larger than the rest, and elsewhere. */
function wholeOf({ surface }: Pane): Orbit {
  const orbit = wholeOrbit();
  if (!surface) return orbit;
  const { centre, diagonal } = frameOf(surface.positions, surface.frame.up);
  orbit.target.copy(centre.applyMatrix4(surface.matrix));
  orbit.distance = Math.min((orbit.distance * diagonal) / surface.frame.diagonal, MAX_DISTANCE);
  return orbit;
}
