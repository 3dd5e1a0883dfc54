import { Matrix4, Vector3 } from 'three';

export type Up = 'x' | 'y' | 'z';

/**
 * The unit frame of a mesh: its box around the origin with a diagonal of 1, and its upward axis along y. Cameras live in this frame,
 * so one camera serves meshes of any unit, place and axis, and near and far planes need no care.
 */
export interface Frame {
  centre: Vector3;
  diagonal: number;
  up: Up;
}

export function frameOf(positions: Float32Array, up: Up): Frame {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = new Vector3(-Infinity, -Infinity, -Infinity);
  const point = new Vector3();
  for (let i = 0; i + 2 < positions.length; i += 3) {
    point.set(positions[i], positions[i + 1], positions[i + 2]);
    if (!Number.isFinite(point.x + point.y + point.z)) continue;
    low.min(point);
    high.max(point);
  }
  if (low.x > high.x) return { centre: new Vector3(), diagonal: 1, up };
  const diagonal = low.distanceTo(high) || 1;
  return { centre: low.add(high).multiplyScalar(0.5), diagonal, up };
}

/** From the mesh's own coordinates to its unit frame. */
export function unitMatrix(frame: Frame): Matrix4 {
  const scale = 1 / frame.diagonal;
  const shift = new Matrix4().makeTranslation(-frame.centre.x, -frame.centre.y, -frame.centre.z);
  return turnUp(frame.up)
    .multiply(new Matrix4().makeScale(scale, scale, scale))
    .multiply(shift);
}

function turnUp(up: Up): Matrix4 {
  if (up === 'z') return new Matrix4().makeRotationX(-Math.PI / 2);
  if (up === 'x') return new Matrix4().makeRotationZ(Math.PI / 2);
  return new Matrix4();
}
