import { BufferAttribute, BufferGeometry, DoubleSide, Ray, Sphere, Vector3 } from 'three';
import { INTERSECTED, MeshBVH, NOT_INTERSECTED } from 'three-mesh-bvh';
import type { Surface } from '../viewer/surface.ts';
import { type Barycentric, barycentricOf } from './barycentric.ts';

export interface Hit {
  triangle: number;
  barycentric: Barycentric;
  /** The corner that is nearest to the hit. */
  vertex: number;
  /** In the unit frame. */
  point: Vector3;
  distance: number;
}

/** Finds what is below the pointer. The tree of boxes is built at the first question and follows the positions of the surface. */
export class Picker {
  private readonly surface: Surface;
  private tree: MeshBVH | null = null;
  private version = -1;

  constructor(surface: Surface) {
    this.surface = surface;
  }

  /** The first visible triangle on a ray of the unit frame. */
  cast(ray: Ray): Hit | null {
    const local = ray.clone().applyMatrix4(this.surface.inverse);
    local.direction.normalize();
    const tree = this.upToDate();
    const found = this.surface.anyHidden
      ? tree
          .raycast(local, DoubleSide)
          .filter((hit) => !this.surface.isHidden(hit.faceIndex ?? 0))
          .sort((a, b) => a.distance - b.distance)[0]
      : tree.raycastFirst(local, DoubleSide);
    if (!found || found.faceIndex === null || found.faceIndex === undefined) return null;
    return this.hit(found.faceIndex, found.point, found.distance);
  }

  /** Whether the surface lies between two points of the unit frame, but for a margin at the second. */
  between(eye: Vector3, point: Vector3): boolean {
    const direction = point.clone().sub(eye);
    const reach = direction.length();
    const hit = this.cast(new Ray(eye.clone(), direction.normalize()));
    return hit !== null && hit.point.distanceTo(eye) < reach - 0.006;
  }

  /** The vertices within a ball around a point of the unit frame. */
  verticesNear(point: Vector3, radius: number, visit: (vertex: number, distance: number) => void): void {
    const { positions, triangles, inverse, frame } = this.surface;
    const centre = point.clone().applyMatrix4(inverse);
    const reach = radius * frame.diagonal;
    const sphere = new Sphere(centre, reach);
    const seen = new Set<number>();
    const corner = new Vector3();
    const tree = this.upToDate();
    tree.shapecast({
      intersectsBounds: (box) => (sphere.intersectsBox(box) ? INTERSECTED : NOT_INTERSECTED),
      intersectsTriangle: (_triangle, index) => {
        if (this.surface.isHidden(index)) return false;
        for (let i = 0; i < 3; i++) {
          const vertex = triangles[index * 3 + i];
          if (seen.has(vertex)) continue;
          seen.add(vertex);
          const distance = corner.fromArray(positions, vertex * 3).distanceTo(centre);
          if (distance <= reach) visit(vertex, distance / reach);
        }
        return false;
      },
    });
  }

  private hit(triangle: number, point: Vector3, distance: number): Hit {
    const { positions, triangles, matrix } = this.surface;
    const corners = [0, 1, 2].map((corner) => triangles[triangle * 3 + corner]);
    const [a, b, c] = corners.map((vertex) => new Vector3().fromArray(positions, vertex * 3)) as [
      Vector3,
      Vector3,
      Vector3,
    ];
    const barycentric = barycentricOf(point, a, b, c);
    const distances = [a, b, c].map((corner) => corner.distanceToSquared(point));
    const vertex = corners[distances.indexOf(Math.min(...distances))];
    return { triangle, barycentric, vertex, point: point.clone().applyMatrix4(matrix), distance };
  }

  private upToDate(): MeshBVH {
    if (!this.tree) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', this.surface.geometry.attributes.position);
      // A copy: hidden components leave the index of the picture, and the tree must not reorder triangles that are named by number.
      geometry.setIndex(new BufferAttribute(this.surface.triangles, 1));
      this.tree = new MeshBVH(geometry, { indirect: true });
      this.version = this.surface.version;
    }
    if (this.version !== this.surface.version) {
      this.tree.refit();
      this.version = this.surface.version;
    }
    return this.tree;
  }
}
