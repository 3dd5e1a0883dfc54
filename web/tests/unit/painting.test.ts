import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Painting } from '../../src/paint/painting.ts';
import type { MeshFacts, Session } from '../../src/protocol/types.ts';

const facts = (file: string, vertices = 2) => ({ file, vertices }) as MeshFacts;
const session = (name: string, source: string, target: string) =>
  ({ name, source: facts(source), target: facts(target) }) as Session;

function painted(): Painting {
  const painting = new Painting();
  painting.open(session('camel-from-horse', 'horse.glb', 'camel.glb'));
  return painting;
}

function stroke(painting: Painting, vertex: number): void {
  painting.begin('the stroke');
  painting.draft().mask.dab(vertex, 0, 1);
  painting.changed();
}

const weights = (painting: Painting) => [...painting.draft().mask.weights];

test('strokes are undone one by one, and made again', () => {
  const painting = painted();
  stroke(painting, 0);
  stroke(painting, 1);
  painting.step(false);
  assert.deepEqual(weights(painting), [1, 0]);
  painting.step(false);
  assert.deepEqual(weights(painting), [0, 0]);
  assert.equal(painting.due(false), null);
  painting.step(true);
  assert.deepEqual(weights(painting), [1, 0]);
  stroke(painting, 1);
  assert.equal(painting.due(true), null);
  // A stroke that ends without a place was none.
  stroke(painting, 1);
  painting.cancel();
  assert.equal(painting.due(true), null);
  assert.deepEqual(weights(painting), [1, 1]);
});

test('a stroke that is undone leaves what is saved, and the other mesh has a draft of its own', () => {
  const painting = painted();
  stroke(painting, 0);
  assert.ok(painting.hasUnsaved);
  const draft = painting.draft();
  const file = { name: 'hump', side: 'target', file: 'hump.target.mask.json', kind: 'weights' } as const;
  draft.markSaved(file, draft.state('weights'));
  stroke(painting, 1);
  assert.ok(!draft.isSaved('weights'));
  painting.step(false);
  assert.ok(draft.isSaved('weights'));
  painting.side.value = 'source';
  stroke(painting, 1);
  painting.side.value = 'target';
  assert.deepEqual(weights(painting), [1, 0]);
  // Undo shows where it has undone something.
  painting.step(false);
  assert.equal(painting.side.peek(), 'source');
  draft.forget(file);
  assert.ok(!draft.isSaved('weights'));
});

test('strokes outlive another clip, and another project', () => {
  const painting = painted();
  stroke(painting, 0);
  assert.deepEqual(painting.open(session('camel-from-horse', 'horse.glb', 'camel.glb')), []);
  assert.deepEqual(weights(painting), [1, 0]);
  assert.deepEqual(painting.open(session('cow-from-horse', 'horse.glb', 'cow.glb')), ['camel.glb']);
  assert.deepEqual(weights(painting), [0, 0]);
  assert.equal(painting.due(false), null);
  assert.ok(painting.hasUnsaved);
  painting.open(session('camel-from-horse', 'horse.glb', 'camel.glb'));
  assert.deepEqual(weights(painting), [1, 0]);
  painting.step(false);
  assert.deepEqual(weights(painting), [0, 0]);
});
