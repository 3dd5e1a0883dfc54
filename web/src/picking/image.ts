import { Triangle, Vector3 } from 'three';
import type { Point } from '../protocol/types.ts';
import type { MeshData } from '../viewer/surface.ts';
import { barycentricOf, pointOn } from './barycentric.ts';

export interface Image {
  point: Point;
  /** Where it lies at rest. */
  position: Vector3;
  /** How far the place beyond the plane is from the surface. */
  distance: number;
}

/** Where a point is at rest. */
export function restPosition({ positions, triangles }: MeshData, point: Point): Vector3 {
  if ('vertex' in point) return new Vector3().fromArray(positions, point.vertex * 3);
  return pointOn(positions, triangles, point.triangle, point.barycentric);
}

/** The place of the surface at rest that is nearest to the mirror image of a point; the plane crosses axis 0, 1 or 2 at `offset`. */
export function mirrorImage(mesh: MeshData, point: Point, axis: number, offset: number): Image {
  const wanted = restPosition(mesh, point);
  wanted.setComponent(axis, 2 * offset - wanted.getComponent(axis));
  const { positions, triangles } = mesh;
  const [triangle, place, nearest] = [new Triangle(), new Vector3(), new Vector3()];
  let [least, found] = [Infinity, 0];
  for (let t = 0; t < triangles.length / 3; t++) {
    triangle.a.fromArray(positions, triangles[t * 3] * 3);
    triangle.b.fromArray(positions, triangles[t * 3 + 1] * 3);
    triangle.c.fromArray(positions, triangles[t * 3 + 2] * 3);
    triangle.closestPointToPoint(wanted, place);
    const distance = place.distanceToSquared(wanted);
    if (distance >= least) continue;
    [least, found] = [distance, t];
    nearest.copy(place);
  }
  const [a, b, c] = [0, 1, 2].map((corner) => new Vector3().fromArray(positions, triangles[found * 3 + corner] * 3));
  const barycentric = barycentricOf(nearest, a, b, c);
  return { point: { triangle: found, barycentric }, position: nearest, distance: Math.sqrt(least) };
}
