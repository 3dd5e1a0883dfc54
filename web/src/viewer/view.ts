import { Color, PerspectiveCamera, type Ray, Raycaster, Scene, Vector2, type Vector3 } from 'three';
import type { Label } from './label.ts';
import { applyOrbit, between, cloneOrbit, type Orbit, wholeOrbit } from './orbit.ts';
import type { TagPlace } from './spread.ts';
import type { Surface } from './surface.ts';

const FLIGHT_MILLISECONDS = 380;

/** One picture of the viewer: a part of the page with its own scene and camera. */
export class View {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera();
  readonly background = new Color(0x202428);
  orbit: Orbit = wholeOrbit();
  labels: Label[] = [];
  /** Where the numbers of labels were in the last picture. */
  tags: ReadonlyMap<number, TagPlace> = new Map();
  /** Whether a place on the mesh is behind something, seen from the eye; labels there are drawn faintly. */
  occluded: ((label: Label) => boolean) | null = null;
  /** Whether the picture no longer shows what is there. */
  dirty = true;
  /** Whether the picture was drawn in a hurry, and is to be drawn again at rest. */
  hurried = false;
  /** Whether one sees through the meshes, so that nothing hides a label. */
  transparent = false;
  width = 1;
  height = 1;
  readonly element: HTMLElement;
  /** Counts meshes that came, since the time of a picture depends on them. */
  changes = 0;
  private readonly surfaces = new Set<Surface>();
  private flight: { from: Orbit; to: Orbit; start: number } | null = null;
  private readonly raycaster = new Raycaster();

  constructor(element: HTMLElement) {
    this.element = element;
  }

  add(surface: Surface): void {
    this.changes += 1;
    this.surfaces.add(surface);
    this.scene.add(surface.group);
  }

  remove(surface: Surface): void {
    this.surfaces.delete(surface);
    this.scene.remove(surface.group);
  }

  setCoarse(coarse: boolean): void {
    for (const surface of this.surfaces) surface.setCoarse(coarse);
  }

  get aspect(): number {
    return this.width / Math.max(this.height, 1);
  }

  get flying(): boolean {
    return this.flight !== null;
  }

  /** Where the camera is, or will be when it has flown. */
  get goal(): Orbit {
    return this.flight?.to ?? this.orbit;
  }

  jumpTo(orbit: Orbit): void {
    this.orbit = cloneOrbit(orbit);
    this.flight = null;
  }

  flyTo(orbit: Orbit, now: number): void {
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) this.jumpTo(orbit);
    else this.flight = { from: cloneOrbit(this.orbit), to: cloneOrbit(orbit), start: now };
  }

  /** The camera stops flying when a person takes it. */
  stopFlight(): void {
    this.flight = null;
  }

  /** Brings the camera to its place for a picture at a time. */
  advance(now: number): void {
    if (this.flight) {
      const t = Math.min((now - this.flight.start) / FLIGHT_MILLISECONDS, 1);
      this.orbit = between(this.flight.from, this.flight.to, Math.max(t, 0));
      if (t >= 1) this.flight = null;
    }
    applyOrbit(this.orbit, this.camera, this.aspect);
  }

  /** The ray through a point of the element, in pixels from its upper left corner, in the unit frame. */
  rayAt(x: number, y: number): Ray {
    applyOrbit(this.orbit, this.camera, this.aspect);
    this.raycaster.setFromCamera(new Vector2(...this.toDevice(x, y)), this.camera);
    return this.raycaster.ray;
  }

  /** From pixels of the element to −1 … 1. */
  toDevice(x: number, y: number): [number, number] {
    return [(x / this.width) * 2 - 1, 1 - (y / this.height) * 2];
  }

  /** Where a point of the unit frame is in the element, in pixels; null behind the eye. */
  project(point: Vector3): [number, number] | null {
    const device = point.clone().project(this.camera);
    if (device.z > 1 || device.z < -1) return null;
    return [((device.x + 1) / 2) * this.width, ((1 - device.y) / 2) * this.height];
  }

  /** How many pixels a length of 1 in the unit frame has at a point. */
  pixelsAt(point: Vector3): number {
    const depth = Math.max(point.distanceTo(this.camera.position), 1e-6);
    return this.height / (2 * depth * Math.tan((this.camera.fov * Math.PI) / 360));
  }
}
