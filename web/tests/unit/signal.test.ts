import assert from 'node:assert/strict';
import { test } from 'node:test';
import { computed, detached, effect, flush, onEffectError, signal } from '../../src/ui/signal.ts';

test('an effect runs once for several changes, and only for what it read', () => {
  const [a, b, c] = [signal(1), signal(2), signal(3)];
  const seen: number[] = [];
  const stop = effect(() => {
    seen.push(a.value === 1 ? b.value : c.value);
  });
  c.value = 4;
  flush();
  assert.deepEqual(seen, [2]);
  a.value = 5;
  b.value = 9;
  flush();
  assert.deepEqual(seen, [2, 4]);
  stop();
  c.value = 6;
  flush();
  assert.deepEqual(seen, [2, 4]);
});

test('computed values follow, and equal ones stir nobody', () => {
  const count = signal(1);
  const even = computed(() => count.value % 2 === 0);
  let runs = 0;
  effect(() => {
    void even.value;
    runs += 1;
  });
  count.value = 3;
  flush();
  assert.equal(runs, 1);
  count.value = 4;
  flush();
  assert.equal(runs, 2);
  assert.equal(even.value, true);
});

test('effects in a circle are an error and hang nothing', () => {
  const count = signal(0);
  effect(() => {
    count.value = count.value + 1;
  });
  assert.throws(flush, /without an end/);
});

test('effects of an effect end with its next run, but detached ones stay', () => {
  const [outer, inner] = [signal(0), signal(0)];
  let runs = 0;
  let detachedRuns = 0;
  effect(() => {
    void outer.value;
    effect(() => {
      void inner.value;
      runs += 1;
    });
    detached(() =>
      effect(() => {
        void inner.value;
        detachedRuns += 1;
      }),
    );
  });
  outer.value = 1;
  flush();
  assert.deepEqual([runs, detachedRuns], [2, 2]);
  inner.value = 1;
  flush();
  assert.deepEqual([runs, detachedRuns], [3, 4]);
});

test('an effect that throws is reported, does not stop the others, and runs again', () => {
  const value = signal<string | null>('a');
  const seen: (number | null)[] = [];
  const errors: unknown[] = [];
  onEffectError((error) => errors.push(error));
  effect(() => void (value.value as string).length);
  effect(() => {
    seen.push(value.value?.length ?? null);
  });
  value.value = null;
  flush();
  value.value = 'bcd';
  flush();
  value.value = null;
  flush();
  assert.deepEqual(seen, [1, null, 3, null]);
  assert.equal(errors.length, 2);
});
