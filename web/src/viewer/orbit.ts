import { type PerspectiveCamera, Vector3 } from 'three';

/** Where a camera is, in the unit frame: it looks at `target` from `distance`, turned by `yaw` about y and raised by `pitch`. */
export interface Orbit {
  target: Vector3;
  yaw: number;
  pitch: number;
  distance: number;
}

export const FIELD_OF_VIEW = 30;
const MIN_DISTANCE = 0.02;
/** The farthest that an eye goes away, in diagonals of the mesh. */
export const MAX_DISTANCE = 12;
const MAX_PITCH = Math.PI / 2 - 0.001;

export function wholeOrbit(): Orbit {
  return { target: new Vector3(), yaw: 0.7, pitch: 0.22, distance: 1.75 };
}

export function cloneOrbit(orbit: Orbit): Orbit {
  return { ...orbit, target: orbit.target.clone() };
}

/** The unit vector from the target to the eye. */
export function eyeDirection(orbit: Orbit): Vector3 {
  const flat = Math.cos(orbit.pitch);
  return new Vector3(Math.sin(orbit.yaw) * flat, Math.sin(orbit.pitch), Math.cos(orbit.yaw) * flat);
}

export function turn(orbit: Orbit, yaw: number, pitch: number): void {
  orbit.yaw -= yaw;
  orbit.pitch = Math.min(Math.max(orbit.pitch + pitch, -MAX_PITCH), MAX_PITCH);
}

/** Turns about a point, which keeps its place in the picture. */
export function turnAbout(orbit: Orbit, pivot: Vector3, yaw: number, pitch: number): void {
  const offset = orbit.target.clone().sub(pivot);
  const parts = [...axes(orbit), eyeDirection(orbit)].map((axis) => offset.dot(axis));
  turn(orbit, yaw, pitch);
  orbit.target.copy(pivot);
  for (const [i, axis] of [...axes(orbit), eyeDirection(orbit)].entries()) orbit.target.addScaledVector(axis, parts[i]);
}

/** The sizes of the picture at the target for an aspect ratio: half its width and half its height. */
export function halfExtent(orbit: Orbit, aspect: number): [number, number] {
  const height = orbit.distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  // A narrow view keeps its width in sight in place of its height.
  return aspect >= 1 ? [height * aspect, height] : [height, height / aspect];
}

/** Moves the picture by parts of its half width and height. */
export function pan(orbit: Orbit, x: number, y: number, aspect: number): void {
  const [right, up] = axes(orbit);
  const [width, height] = halfExtent(orbit, aspect);
  orbit.target.addScaledVector(right, -x * width).addScaledVector(up, -y * height);
}

/** Scales the distance; the point at `x`, `y` of the picture (−1 to 1) stays in place. */
export function zoom(orbit: Orbit, factor: number, x: number, y: number, aspect: number): void {
  const distance = Math.min(Math.max(orbit.distance * factor, MIN_DISTANCE), MAX_DISTANCE);
  const applied = distance / orbit.distance;
  const [right, up] = axes(orbit);
  const [width, height] = halfExtent(orbit, aspect);
  orbit.target.addScaledVector(right, x * width * (1 - applied)).addScaledVector(up, y * height * (1 - applied));
  orbit.distance = distance;
}

function axes(orbit: Orbit): [Vector3, Vector3] {
  const direction = eyeDirection(orbit);
  const right = new Vector3(Math.cos(orbit.yaw), 0, -Math.sin(orbit.yaw));
  return [right, direction.clone().cross(right)];
}

export function applyOrbit(orbit: Orbit, camera: PerspectiveCamera, aspect: number): void {
  const [, height] = halfExtent(orbit, aspect);
  camera.fov = (Math.atan(height / orbit.distance) * 360) / Math.PI;
  camera.aspect = aspect;
  camera.near = Math.max(orbit.distance - 2, orbit.distance * 0.02, 0.001);
  camera.far = orbit.distance + 4;
  camera.position.copy(eyeDirection(orbit)).multiplyScalar(orbit.distance).add(orbit.target);
  camera.up.set(0, 1, 0);
  camera.lookAt(orbit.target);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}

/** Between two places, `t` from 0 to 1; turns the shorter way round. */
export function between(from: Orbit, to: Orbit, t: number): Orbit {
  const ease = t * t * (3 - 2 * t);
  const yaw = ((((to.yaw - from.yaw + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI;
  return {
    target: from.target.clone().lerp(to.target, ease),
    yaw: from.yaw + yaw * ease,
    pitch: from.pitch + (to.pitch - from.pitch) * ease,
    distance: from.distance * (to.distance / from.distance) ** ease,
  };
}

/** A place near `point` that looks at it along its normal, but not from below or above where the way there would confuse. */
export function facing(point: Vector3, normal: Vector3, distance: number): Orbit {
  const flat = Math.hypot(normal.x, normal.z);
  const yaw = flat > 0.15 ? Math.atan2(normal.x, normal.z) : 0.7;
  const pitch = Math.min(Math.max(Math.atan2(normal.y, flat), -0.35), 0.8);
  return { target: point.clone(), yaw, pitch, distance };
}
