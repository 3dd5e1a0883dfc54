import assert from 'node:assert/strict';
import { test } from 'node:test';
import { falloff, maskNameProblem, PaintedMask } from '../../src/paint/mask.ts';

test('strokes stay between 0 and 1 and are undone one by one', () => {
  const mask = new PaintedMask(2);
  mask.beginStroke();
  mask.dab(0, 0, 0.7);
  mask.dab(0, 0, 0.7);
  mask.beginStroke();
  mask.dab(1, 0.5, 1);
  assert.equal(mask.weights[0], 1);
  assert.ok(mask.weights[1] > 0.5 && mask.weights[1] < 0.6);
  mask.undo();
  assert.deepEqual([...mask.weights], [1, 0]);
  mask.undo();
  assert.deepEqual([...mask.weights], [0, 0]);
  mask.undo();
  mask.redo();
  assert.deepEqual([...mask.weights], [1, 0]);
  mask.change((weight) => 1 - weight);
  assert.deepEqual([...mask.weights], [0, 1]);
  assert.ok(!mask.canRedo);
});

test('the brush is soft', () => {
  assert.equal(falloff(0), 1);
  assert.equal(falloff(1), 0);
  assert.equal(falloff(2), 0);
  assert.ok(falloff(0.3) > falloff(0.6));
});

test('names become files, so they are plain', () => {
  assert.equal(maskNameProblem('jaw_1'), null);
  for (const name of ['', '../x', 'a b', '-a', 'a/b', 'x'.repeat(65)]) assert.ok(maskNameProblem(name), name);
});
