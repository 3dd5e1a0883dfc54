import { Vector3 } from 'three';

export type Barycentric = [number, number, number];

/** The point of a triangle with barycentric coordinates. */
export function pointOn(
  positions: Float32Array,
  triangles: Uint32Array,
  triangle: number,
  barycentric: Barycentric,
): Vector3 {
  const result = new Vector3();
  for (let corner = 0; corner < 3; corner++) {
    const v = triangles[triangle * 3 + corner] * 3;
    const weight = barycentric[corner];
    result.x += positions[v] * weight;
    result.y += positions[v + 1] * weight;
    result.z += positions[v + 2] * weight;
  }
  return result;
}

/** Barycentric coordinates of a point in the plane of a triangle, clamped into it; of a triangle without area, its first corner. */
export function barycentricOf(point: Vector3, a: Vector3, b: Vector3, c: Vector3): Barycentric {
  const u = b.clone().sub(a);
  const v = c.clone().sub(a);
  const w = point.clone().sub(a);
  const [uu, uv, vv, wu, wv] = [u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v)];
  const area = uu * vv - uv * uv;
  if (!(area > 0)) return [1, 0, 0];
  const second = Math.max((vv * wu - uv * wv) / area, 0);
  const third = Math.max((uu * wv - uv * wu) / area, 0);
  const first = Math.max(1 - second - third, 0);
  const sum = first + second + third;
  return [first / sum, second / sum, third / sum];
}

export function triangleNormal(positions: Float32Array, triangles: Uint32Array, triangle: number): Vector3 {
  const [a, b, c] = [0, 1, 2].map((corner) =>
    new Vector3().fromArray(positions, triangles[triangle * 3 + corner] * 3),
  ) as [Vector3, Vector3, Vector3];
  return b.sub(a).cross(c.sub(a)).normalize();
}
