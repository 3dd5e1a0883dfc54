import assert from 'node:assert/strict';
import { test } from 'node:test';
import { EMPTY } from '../../src/markers/empty.ts';
import { EditQueue } from '../../src/markers/queue.ts';
import { recoverEdits } from '../../src/markers/recover.ts';
import type { EditResult, Markers, Pair } from '../../src/protocol/types.ts';

function pair(id: number, more: Partial<Pair> = {}): Pair {
  return {
    id,
    number: id,
    colour: id,
    name: `p${id}`,
    note: null,
    source: { vertex: id },
    target: { vertex: id },
    status: 'proposed',
    confidence: 0.5,
    origin: 'proposed',
    revision: 1,
    ...more,
  };
}

function document(revision: number, pairs: Pair[]): Markers {
  return { ...EMPTY, revision, pairs };
}

function answer(markers: Markers, added: (number | null)[] = []): EditResult {
  return { markers, added, conflicts: [], mirrored: null };
}

test('an edit shows at once and after the answer', () => {
  const queue = new EditQueue(document(1, [pair(1)]));
  queue.push([{ op: 'move', pair: 1, side: 'target', point: { vertex: 9 } }], 'a');
  assert.deepEqual(queue.pairs[0].target, { vertex: 9 });
  assert.equal(queue.pairs[0].status, 'confirmed');
  queue.acknowledge('a', answer(document(2, [pair(1, { target: { vertex: 9 }, status: 'confirmed' })])));
  assert.deepEqual(queue.pairs[0].target, { vertex: 9 });
  assert.equal(queue.waiting.length, 0);
});

test('a new pair is edited before the server has given it an id', () => {
  const queue = new EditQueue(document(1, []));
  const { added } = queue.push([{ op: 'add', source: { vertex: 3 } }], 'a');
  queue.push([{ op: 'move', pair: added[0], side: 'target', point: { vertex: 4 } }], 'b');
  assert.deepEqual(
    queue.pairs.map((one) => [one.source, one.target]),
    [[{ vertex: 3 }, { vertex: 4 }]],
  );
  const ids = queue.acknowledge('a', answer(document(2, [pair(7, { target: null })]), [7]));
  assert.equal(ids.get(added[0]), 7);
  assert.deepEqual(queue.waiting[0].ops, [{ op: 'move', pair: 7, side: 'target', point: { vertex: 4 } }]);
  assert.deepEqual(queue.pairs[0].target, { vertex: 4 });
});

test('an edit keeps the revision that its person saw', () => {
  const queue = new EditQueue(document(1, [pair(1)]));
  queue.push([{ op: 'rename', pair: 1, name: 'a' }], 'a');
  queue.push([{ op: 'rename', pair: 1, name: 'b' }], 'b');
  queue.acknowledge('a', answer(document(3, [pair(1, { name: 'a' })])));
  assert.equal(queue.waiting[0].base, 1);
});

test('a server that was started anew gets the edits, for the pairs that were meant', () => {
  const queue = new EditQueue(document(8, [pair(4, { name: 'nose' }), pair(5, { name: 'ear' })]));
  queue.push([{ op: 'move', pair: 5, side: 'target', point: { vertex: 7 } }], 'a');
  const added = { triangle: 3, barycentric: [0.2, 0.3, 0.5] as [number, number, number] };
  queue.push([{ op: 'add', source: added }], 'b');
  queue.push([{ op: 'add', source: { vertex: 1 } }], 'c');
  // The server saved the edit b before it ended, and reads numbers from the file with fewer digits.
  const saved = pair(3, { source: { triangle: 3, barycentric: [0.20001, 0.3, 0.49999] }, target: null });
  const anew = document(1, [pair(1, { name: 'nose' }), pair(2, { name: 'ear' }), saved]);
  const recovered = recoverEdits(queue.waiting, anew);
  assert.deepEqual(
    recovered.map(({ id, base, ops }) => [id, base, ops]),
    [
      ['a', 1, [{ op: 'move', pair: 2, side: 'target', point: { vertex: 7 } }]],
      ['c', 1, [{ op: 'add', source: { vertex: 1 } }]],
    ],
  );
});

test('an edit that was not sent is taken back without the server', () => {
  const queue = new EditQueue(document(1, [pair(1)]));
  queue.push([{ op: 'delete', pair: 1 }], 'a');
  assert.equal(queue.dropLast('a'), null);
  assert.ok(queue.dropLast(null));
  assert.equal(queue.pairs.length, 1);
});

test('edits that an earlier page could not send come back, and new ids do not meet theirs', () => {
  const first = new EditQueue(document(1, []));
  const { added } = first.push([{ op: 'add', source: { vertex: 1 } }], 'a');
  const second = new EditQueue(document(1, []), first.waiting);
  assert.equal(second.pairs.length, 1);
  assert.notEqual(second.push([{ op: 'add', source: { vertex: 2 } }], 'b').added[0], added[0]);
  assert.equal(new Set(second.pairs.map((one) => one.id)).size, 2);
});

test('late news of an older revision is not taken', () => {
  const queue = new EditQueue(document(5, [pair(1)]));
  queue.receive(document(4, []));
  assert.equal(queue.pairs.length, 1);
  queue.receive(document(6, []));
  assert.equal(queue.pairs.length, 0);
});

test('order follows, and numbers stay', () => {
  const queue = new EditQueue(document(1, [pair(1), pair(2), pair(3)]));
  queue.push([{ op: 'reorder', pair: 3, before: 1 }], 'a');
  assert.deepEqual(
    queue.pairs.map((one) => [one.id, one.number]),
    [
      [3, 3],
      [1, 1],
      [2, 2],
    ],
  );
  queue.push([{ op: 'reorder', pair: 3, before: null }], 'b');
  assert.deepEqual(
    queue.pairs.map((one) => one.id),
    [1, 2, 3],
  );
});
