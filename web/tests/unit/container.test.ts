import assert from 'node:assert/strict';
import { test } from 'node:test';
import { floats, readContainer, words, writeContainer } from '../../src/protocol/container.ts';

const arrays = { positions: new Float32Array([1, 2.5, -3]), triangles: new Uint32Array([0, 1, 4294967295]) };

test('what is written is read again, whatever the length of the header', () => {
  for (let length = 0; length < 9; length++) {
    const note = 'ü'.repeat(length);
    const { header, arrays: read } = readContainer<{ note: string }>(writeContainer({ note }, arrays));
    assert.equal(header.note, note);
    assert.deepEqual(floats(read, 'positions'), arrays.positions);
    assert.deepEqual(words(read, 'triangles'), arrays.triangles);
  }
});

test('arrays look at the buffer and copy nothing', () => {
  const buffer = writeContainer({}, arrays);
  assert.equal(floats(readContainer(buffer).arrays, 'positions').buffer, buffer);
});

test('damaged data is refused', () => {
  const buffer = writeContainer({}, arrays);
  for (const length of [0, 7, 8, 20, buffer.byteLength - 1]) {
    assert.throws(() => readContainer(buffer.slice(0, length)), /cut off/);
  }
  const other = buffer.slice(0);
  new Uint8Array(other)[3] = 0x32;
  assert.throws(() => readContainer(other), /another kind/);
});

test('a missing array is named', () => {
  assert.throws(() => floats(readContainer(writeContainer({}, {})).arrays, 'scalars'), /scalars/);
});
