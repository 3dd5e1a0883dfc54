import assert from 'node:assert/strict';
import { test } from 'node:test';
import { PerspectiveCamera, Vector3 } from 'three';
import { isSolid } from '../../src/viewer/closed.ts';
import { coarseTriangles } from '../../src/viewer/coarse.ts';
import { COLOUR_MAPS, colourTable, formatNumber, legendRange, sampleColour, ticks } from '../../src/viewer/colours.ts';
import { frameOf, unitMatrix } from '../../src/viewer/frame.ts';
import { computeNormals, representatives } from '../../src/viewer/normals.ts';
import { applyOrbit, between, pan, turn, turnAbout, wholeOrbit, zoom } from '../../src/viewer/orbit.ts';
import { spread } from '../../src/viewer/spread.ts';

const TETRAHEDRON = {
  positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]),
  triangles: new Uint32Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]),
};

test('colour maps go from their first to their last colour and never leave them', () => {
  for (const name of COLOUR_MAPS) {
    assert.deepEqual(sampleColour(name, -1), sampleColour(name, 0));
    assert.deepEqual(sampleColour(name, 2), sampleColour(name, 1));
    assert.equal(colourTable(name, 256).length, 1024);
    assert.notDeepEqual(sampleColour(name, 0), sampleColour(name, 1));
  }
});

test('limits of a legend are round, even about zero for signed values, and deaf to single outliers', () => {
  assert.deepEqual(legendRange(new Float32Array([0, 0.5, 1.83])), [0, 2]);
  assert.deepEqual(legendRange(new Float32Array([-3.2, 0, 1])), [-4, 4]);
  assert.deepEqual(legendRange(new Float32Array([Number.NaN])), [0, 1]);
  const many = new Float32Array(1000).fill(1);
  many[3] = 500;
  assert.deepEqual(legendRange(many), [0, 1]);
  assert.deepEqual(ticks(0, 2, 5), [0, 0.5, 1, 1.5, 2]);
  assert.deepEqual([0, 0.30000000000000004, 123456, 0.00001].map(formatNumber), ['0', '0.3', '1.2e+5', '1.0e-5']);
});

test('any mesh fits the unit frame, with its upward axis along y', () => {
  const positions = new Float32Array([1000, 2000, 3000, 1000, 2000, 3400]);
  const matrix = unitMatrix(frameOf(positions, 'z'));
  const top = new Vector3(1000, 2000, 3400).applyMatrix4(matrix);
  assert.ok(top.distanceTo(new Vector3(0, 0.5, 0)) < 1e-6);
  const empty = frameOf(new Float32Array([Number.NaN, 0, 0]), 'y');
  assert.equal(empty.diagonal, 1);
});

test('normals are those of the faces, and one along seams', () => {
  const { positions, triangles } = TETRAHEDRON;
  const normals = new Float32Array(12);
  computeNormals(positions, triangles, new Uint32Array([0, 1, 2, 3]), normals);
  assert.ok(normals[0] < 0 && normals[1] < 0 && normals[2] < 0);
  assert.deepEqual([...representatives(new Uint32Array([5, 7, 5, 0xffffffff]))], [0, 1, 0, 3]);
});

test('closed meshes are told from open, inverted and torn ones', () => {
  const { positions, triangles } = TETRAHEDRON;
  const one = new Uint32Array(4);
  const welded = new Uint32Array([0, 1, 2, 3]);
  assert.ok(isSolid(positions, triangles, one, welded));
  assert.ok(!isSolid(positions, triangles.slice(0, 9), one.slice(0, 3), welded));
  assert.ok(!isSolid(positions, triangles.slice().reverse(), one, welded));
  const turned = triangles.slice();
  [turned[0], turned[1]] = [turned[1], turned[0]];
  assert.ok(!isSolid(positions, turned, one, welded));
});

test('the coarse mesh has fewer triangles, each of three vertices of the mesh', () => {
  const side = 40;
  const positions = new Float32Array(side * side * 3);
  const triangles: number[] = [];
  for (let i = 0; i < side * side; i++) positions.set([i % side, Math.floor(i / side), 0], i * 3);
  for (let i = 0; i < side * (side - 1); i++) {
    if (i % side < side - 1) triangles.push(i, i + 1, i + side, i + 1, i + side + 1, i + side);
  }
  const coarse = coarseTriangles(positions, new Uint32Array(triangles), 10);
  assert.ok(coarse.length > 0 && coarse.length < triangles.length / 8);
  for (let t = 0; t < coarse.length; t += 3) assert.equal(new Set(coarse.slice(t, t + 3)).size, 3);
});

test('zoom keeps the point below the pointer, pan follows the hand', () => {
  const camera = new PerspectiveCamera();
  const orbit = wholeOrbit();
  turn(orbit, 0.4, 0.2);
  applyOrbit(orbit, camera, 0.8);
  // A point in the plane of the target is what stays.
  const before = new Vector3(0.5, -0.3, 0).applyMatrix4(camera.projectionMatrixInverse);
  const point = before.multiplyScalar(orbit.distance / -before.z).applyMatrix4(camera.matrixWorld);
  zoom(orbit, 0.6, 0.5, -0.3, 0.8);
  applyOrbit(orbit, camera, 0.8);
  const after = point.clone().project(camera);
  assert.ok(Math.hypot(after.x - 0.5, after.y + 0.3) < 1e-6);
  pan(orbit, 0.25, 0, 0.8);
  applyOrbit(orbit, camera, 0.8);
  assert.ok(Math.abs(point.clone().project(camera).x - 0.75) < 1e-6);
});

test('a flight begins and ends in its places and takes the shorter way round', () => {
  const from = { ...wholeOrbit(), yaw: 3 };
  const to = { ...wholeOrbit(), yaw: -3 };
  assert.equal(between(from, to, 0).yaw, 3);
  const end = between(from, to, 1).yaw;
  assert.ok(Math.abs(Math.cos(end) - Math.cos(-3)) < 1e-12);
  assert.ok(Math.abs(between(from, to, 0.5).yaw - Math.PI) < 0.2);
});

test('a turn about a point leaves it in its place of the picture', () => {
  const orbit = { ...wholeOrbit(), target: new Vector3(0.3, -0.4, 0.1), distance: 0.8 };
  const pivot = new Vector3(0, 0.05, 0);
  const camera = new PerspectiveCamera();
  const place = () => {
    applyOrbit(orbit, camera, 1.5);
    return pivot.clone().applyMatrix4(camera.matrixWorldInverse);
  };
  const before = place();
  turnAbout(orbit, pivot, 1.2, 0.3);
  assert.ok(place().distanceTo(before) < 1e-9);
});

test('numbers of points that lie close do not cover each other, and stay where they are', () => {
  const spots = Array.from({ length: 7 }, (_, id) => ({ id, x: 100 + 3 * id, y: 100 + (id % 2), half: 10 }));
  const places = spread(spots, new Map());
  const at = spots.map(({ id, x, y }) => [x + (places.get(id)?.dx ?? 0), y + (places.get(id)?.dy ?? 0)]);
  for (const [i, [x, y]] of at.entries())
    for (const [u, v] of at.slice(i + 1)) assert.ok(Math.abs(x - u) > 20 || Math.abs(y - v) > 16);
  assert.deepEqual(spread(spots, places), places);
  assert.equal(spread(spots.slice(0, 1), new Map()).get(0)?.led, false);
});
