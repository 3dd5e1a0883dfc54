import assert from 'node:assert/strict';
import { test } from 'node:test';
import { follows } from '../../src/app/jobs.ts';
import type { Job } from '../../src/protocol/types.ts';

const job = (state: Job['state']) => ({ id: 7, state }) as Job;

test('a job that has ended does not run again because the answer to its beginning comes late', () => {
  assert.ok(follows(job('running'), undefined));
  assert.ok(follows(job('failed'), job('running')));
  assert.ok(!follows(job('running'), job('failed')));
  assert.ok(follows(job('cancelled'), job('cancelled')));
});
