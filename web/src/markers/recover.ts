import type { Markers, Op, Pair, Point } from '../protocol/types.ts';
import { renumberOp } from './apply.ts';
import type { PairName, PendingEdit } from './queue.ts';

const SAME_WEIGHT = 1e-4;

/**
 * Edits that were not answered, for a document that may come from a server that was started since. Pairs are found again by their names,
 * and a pair that was added before the server ended is not added twice.
 */
export function recoverEdits(edits: readonly PendingEdit[], document: Markers): PendingEdit[] {
  const recovered: PendingEdit[] = [];
  const ids = new Map<number, number>();
  for (const edit of edits) {
    for (const named of edit.names) {
      const found = findPair(named, document.pairs);
      if (found) ids.set(named.id, found.id);
    }
    let newId = edit.firstNewId;
    const ops: Op[] = [];
    for (const op of edit.ops) {
      const there = op.op === 'add' ? findAdded(op, document.pairs) : null;
      // Later edits of the pair go to the one that is there.
      if (there) ids.set(newId, there.id);
      else ops.push(renumberOp(op, ids));
      if (op.op === 'add') newId -= 1;
    }
    if (ops.length === 0) continue;
    // A revision that the server has not reached belongs to an earlier server.
    recovered.push({ ...edit, ops, base: Math.min(edit.base, document.revision) });
  }
  return recovered;
}

function findPair(named: PairName, pairs: readonly Pair[]): Pair | null {
  const same = pairs.find((pair) => pair.id === named.id && pair.name === named.name);
  if (same) return same;
  if (named.name !== null) return pairs.find((pair) => pair.name === named.name) ?? null;
  return pairs.find((pair) => pair.number === named.number && pair.name === null) ?? null;
}

function findAdded(op: Extract<Op, { op: 'add' }>, pairs: readonly Pair[]): Pair | null {
  const same = (pair: Pair) => samePoint(op.source ?? null, pair.source) && samePoint(op.target ?? null, pair.target);
  return pairs.find(same) ?? null;
}

function samePoint(a: Point | null, b: Point | null): boolean {
  if (a === null || b === null) return a === b;
  if ('vertex' in a) return 'vertex' in b && a.vertex === b.vertex;
  if ('vertex' in b || a.triangle !== b.triangle) return false;
  return a.barycentric.every((weight, i) => Math.abs(weight - b.barycentric[i]) < SAME_WEIGHT);
}
