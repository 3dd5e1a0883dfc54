import assert from 'node:assert/strict';
import { test } from 'node:test';
import { falloff, maskNameProblem, PaintedMask } from '../../src/paint/mask.ts';

test('weights stay between 0 and 1', () => {
  const mask = new PaintedMask(2);
  mask.dab(0, 0, 0.7);
  mask.dab(0, 0, 0.7);
  mask.dab(1, 0.5, 1);
  assert.equal(mask.weights[0], 1);
  assert.ok(mask.weights[1] > 0.5 && mask.weights[1] < 0.6);
  mask.change((weight) => 1 - weight);
  assert.equal(mask.weights[0], 0);
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
