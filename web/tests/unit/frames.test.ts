import assert from 'node:assert/strict';
import { test } from 'node:test';
import { frameAt, replaces } from '../../src/live/frames.ts';

const base = { channel: 'preview', look: 5, revision: 3, pipeline: 1, drag: null };

test('the result takes the place of the preview of the same state, not the other way round', () => {
  assert.ok(replaces(base, { ...base, channel: 'result' }));
  assert.ok(!replaces({ ...base, channel: 'result' }, base));
});

test('a newer state wins, whatever its kind', () => {
  const result = { ...base, channel: 'result' };
  assert.ok(replaces(result, { ...base, look: 6 }));
  assert.ok(replaces(result, { ...base, revision: 4 }));
  assert.ok(!replaces({ ...base, revision: 4 }, { ...result, look: 5 }));
  assert.ok(!replaces({ ...base, look: 6 }, result));
});

test('while a point is dragged, only previews of the drag and newer ones show', () => {
  const drag = { ...base, drag: 8 };
  assert.ok(replaces({ ...base, channel: 'result' }, drag));
  assert.ok(!replaces(drag, { ...base, channel: 'result' }));
  assert.ok(replaces(drag, { ...base, drag: 9 }));
  assert.ok(!replaces({ ...base, drag: 9 }, drag));
  // The drag is over: its edit made a revision, or it was given up.
  assert.ok(replaces(drag, { ...base, revision: 4 }));
  assert.ok(replaces(drag, base));
});

test('a clip is played round and round at its rate', () => {
  assert.equal(frameAt(0, 24, 10), 0);
  assert.equal(frameAt(0.999 / 24, 24, 10), 0);
  assert.equal(frameAt(1 / 24, 24, 10), 1);
  assert.equal(frameAt(10 / 24, 24, 10), 0);
  assert.equal(frameAt(-0.01, 24, 10), 9);
  assert.equal(frameAt(3, 24, 0), 0);
});
