import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type MirrorSide, mirroredName, mirrorOne } from '../../src/markers/mirrorone.ts';
import type { MeshFacts, Pair } from '../../src/protocol/types.ts';
import type { MeshData } from '../../src/viewer/surface.ts';

/** A square in x and y, from -1 to 1. */
const square: MirrorSide = {
  mesh: {
    positions: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]),
    triangles: new Uint32Array([0, 1, 2, 0, 2, 3]),
  } as MeshData,
  facts: { origin: [5, 0, 0], diagonal: Math.sqrt(8) } as unknown as MeshFacts,
  offset: undefined,
};
const sides = { source: square, target: square };
const pair = (id: number, vertex: number, name: string | null = null) =>
  ({ id, number: id, name, source: { vertex }, target: { vertex } }) as Pair;

test('one pair gets its partner beyond the plane, where there is none yet', () => {
  const one = pair(1, 1, 'limb2-1');
  const result = mirrorOne(one, [one], 'x', sides);
  assert.ok('op' in result);
  assert.equal(result.op.name, 'limb2-1 mirrored');
  assert.deepEqual(result.op.source, { triangle: 0, barycentric: [1, 0, 0] });
  assert.deepEqual(mirrorOne(one, [one, pair(2, 0)], 'x', sides), { problem: 'Its partner is there already: Pair 2.' });
  // The plane is given in the unit of the file, whose middle is at 5.
  const moved = { source: { ...square, offset: 5 }, target: { ...square, offset: 5.9 } };
  assert.match(JSON.stringify(mirrorOne(one, [one], 'x', moved)), /barycentric/);
  const outside = { source: square, target: { ...square, offset: 7 } };
  assert.deepEqual(mirrorOne(one, [one], 'x', outside), { problem: 'Beyond the plane there is no target.' });
  assert.deepEqual(mirrorOne(one, [one], 'z', sides), { problem: 'It lies on the plane.' });
  assert.match(JSON.stringify(mirrorOne({ ...one, target: null }, [one], 'x', sides)), /no point on the target/);
});

test('mirrored names name the other side, and are free', () => {
  const none = new Set<string>();
  assert.equal(mirroredName('front.L knee', none), 'front.L knee mirrored');
  assert.equal(mirroredName('ear.L', none), 'ear.R');
  assert.equal(mirroredName('R_ear', none), 'L_ear');
  assert.equal(mirroredName('earLeft', none), 'earRight');
  assert.equal(mirroredName('left ear', none), 'right ear');
  assert.equal(mirroredName('cleft', none), 'cleft mirrored');
  assert.equal(mirroredName('nose', new Set(['nose mirrored'])), 'nose mirrored 2');
  assert.equal(mirroredName(null, none), undefined);
});
