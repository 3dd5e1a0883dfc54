import assert from 'node:assert/strict';
import { test } from 'node:test';
import { doubtfulFirst, matches, needOf, neighbour } from '../../src/markers/order.ts';
import type { Pair } from '../../src/protocol/types.ts';

function pair(number: number, more: Partial<Pair> = {}): Pair {
  return {
    id: number,
    number,
    colour: 0,
    name: null,
    note: null,
    source: { vertex: 0 },
    target: { vertex: 0 },
    status: 'confirmed',
    confidence: null,
    origin: 'user',
    revision: 1,
    ...more,
  };
}

test('what needs a person comes first, the least sure before others', () => {
  const pairs = [
    pair(1),
    pair(2, { status: 'proposed', confidence: 0.9 }),
    pair(3, { status: 'skipped' }),
    pair(4, { status: 'proposed', confidence: 0.1 }),
    pair(5, { target: null }),
  ];
  assert.deepEqual(
    doubtfulFirst(pairs).map((one) => one.number),
    [5, 4, 2, 1, 3],
  );
  assert.deepEqual(pairs.map(needOf), ['none', 'proposed', 'none', 'doubtful', 'partner']);
});

test('a search takes every word, of the name, the number and the note', () => {
  const nose = pair(12, { name: 'Nose tip', note: 'check' });
  for (const search of ['', 'nose', 'TIP nose', '12', 'check']) assert.ok(matches(nose, search), search);
  assert.ok(!matches(nose, 'nose ear'));
});

test('neighbours go round the end, and begin at an end if none is selected', () => {
  const list = [pair(1), pair(2), pair(3)];
  assert.equal(neighbour(list, 3, 1)?.id, 1);
  assert.equal(neighbour(list, 1, -1)?.id, 3);
  assert.equal(neighbour(list, null, 1)?.id, 1);
  assert.equal(neighbour(list, null, -1)?.id, 3);
  assert.equal(neighbour([], 1, 1), null);
});
