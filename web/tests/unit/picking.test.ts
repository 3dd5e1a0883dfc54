import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Ray, Vector3 } from 'three';
import { barycentricOf, pointOn } from '../../src/picking/barycentric.ts';
import { Picker } from '../../src/picking/picker.ts';
import { Surface } from '../../src/viewer/surface.ts';

const positions = new Float32Array([0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, -1, 2, 0, -1, 0, 2, -1]);
const data = {
  positions,
  triangles: new Uint32Array([0, 1, 2, 3, 4, 5]),
  components: new Uint32Array([0, 1]),
  welded: new Uint32Array([0, 1, 2, 3, 4, 5]),
  edges: new Uint32Array([0, 1, 1, 2, 2, 0]),
};

function rayAt(surface: Surface, x: number, y: number): Ray {
  const eye = new Vector3(x, y, 5).applyMatrix4(surface.matrix);
  return new Ray(eye, new Vector3(0, 0, -1));
}

test('barycentric coordinates give the point back', () => {
  const [a, b, c] = [new Vector3(1, 2, 3), new Vector3(4, 0, 1), new Vector3(-2, 5, 0)];
  const weights = [0.2, 0.3, 0.5];
  const point = a.clone().multiplyScalar(0.2).addScaledVector(b, 0.3).addScaledVector(c, 0.5);
  barycentricOf(point, a, b, c).forEach((value, i) => {
    assert.ok(Math.abs(value - weights[i]) < 1e-12);
  });
});

test('points beside a triangle are drawn into it, and no area gives no NaN', () => {
  const [a, b] = [new Vector3(), new Vector3(1, 0, 0)];
  const outside = barycentricOf(new Vector3(-1, -1, 0), a, b, new Vector3(0, 1, 0));
  assert.ok(outside.every((value) => value >= 0));
  assert.ok(Math.abs(outside[0] + outside[1] + outside[2] - 1) < 1e-12);
  assert.deepEqual(barycentricOf(new Vector3(3, 0, 0), a, b, new Vector3(2, 0, 0)), [1, 0, 0]);
});

test('a ray finds the first triangle, its place and its nearest vertex', () => {
  const surface = new Surface(data);
  const hit = new Picker(surface).cast(rayAt(surface, 1.5, 0.2));
  assert.equal(hit?.triangle, 0);
  assert.equal(hit?.vertex, 1);
  const place = pointOn(positions, data.triangles, 0, hit?.barycentric ?? [0, 0, 0]);
  assert.ok(place.distanceTo(new Vector3(1.5, 0.2, 0)) < 1e-5);
  assert.equal(new Picker(surface).cast(rayAt(surface, 3, 3)), null);
});

test('hidden components are passed through, and moved ones are found where they are', () => {
  const surface = new Surface(data);
  const picker = new Picker(surface);
  surface.hide(new Set([0]));
  assert.equal(picker.cast(rayAt(surface, 0.5, 0.5))?.triangle, 1);
  surface.hide(new Set());
  surface.setPositions(positions.map((value, i) => (i % 3 === 2 ? -value : value)));
  assert.equal(picker.cast(rayAt(surface, 0.5, 0.5))?.triangle, 1);
});

test('a ball finds the vertices within it', () => {
  const surface = new Surface(data);
  const found: number[] = [];
  const centre = new Vector3(0, 0, 0).applyMatrix4(surface.matrix);
  new Picker(surface).verticesNear(centre, 1.2 / surface.frame.diagonal, (vertex) => found.push(vertex));
  assert.deepEqual(found.sort(), [0, 3]);
});
