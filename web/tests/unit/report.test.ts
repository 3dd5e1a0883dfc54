import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type Coordinates, numbers16, positionsOf, trianglesOf, valuesOf } from '../../src/report/data.ts';
import { componentsOf, edgesOf } from '../../src/report/topology.ts';

/** Numbers of 16 bits as a report writes them, low byte first. */
function base64(...numbers: number[]): string {
  return btoa(String.fromCharCode(...numbers.flatMap((number) => [number & 255, number >> 8])));
}

test('positions lie between the corners of their box, and values on their scale', () => {
  assert.deepEqual([...numbers16(base64(0, 258, 65535))], [0, 258, 65535]);
  const positions = positionsOf({ low: [1, 2, 3], size: [2, 0, 4], steps: base64(0, 7, 65535, 65535, 0, 0) });
  assert.deepEqual([...positions], [1, 2, 7, 3, 2, 3]);
  const values = valuesOf({ unit: 'error, %', high: 5, over: false, steps: base64(0, 65534, 65535) });
  assert.deepEqual([...values], [0, 5, Number.NaN]);
});

test('numbers of vertices have 16 bits or 32', () => {
  const rest: Coordinates = { low: [0, 0, 0], size: [1, 1, 1], steps: '' };
  const mesh = { rest, continues: null };
  assert.deepEqual([...trianglesOf({ ...mesh, wide: false, triangles: base64(1, 2, 3) })], [1, 2, 3]);
  assert.deepEqual([...trianglesOf({ ...mesh, wide: true, triangles: base64(1, 0, 2, 1) })], [1, 65538]);
});

test('triangles that share no vertex are of two components', () => {
  const triangles = new Uint32Array([5, 6, 7, 0, 1, 2, 2, 3, 0]);
  assert.deepEqual([...componentsOf(triangles, 8)], [0, 1, 1]);
});

test('a wireframe has the edges of polygons, each once and without diagonals', () => {
  const square = new Uint32Array([0, 1, 2, 0, 2, 3]);
  assert.equal(edgesOf(square, null).length / 2, 5);
  const edges = edgesOf(square, new Uint8Array([0, 1]));
  assert.deepEqual([...edges], [0, 1, 1, 2, 2, 3, 3, 0]);
  // A triangle that was turned over has the same diagonal.
  assert.equal(edgesOf(new Uint32Array([0, 1, 2, 0, 3, 2]), new Uint8Array([0, 1])).length / 2, 4);
});
