import type { Edit, EditResult, Markers, Op, Pair } from '../protocol/types.ts';
import { applyOps, renumberOp } from './apply.ts';

/** How a pair was called when an edit of it was made, and its place, since a server that was started anew numbers pairs anew. */
export type PairName = Pick<Pair, 'id' | 'name' | 'number'>;

export interface PendingEdit extends Pick<Edit, 'base' | 'id' | 'ops'> {
  /** What the pairs of the operations are called. */
  names: PairName[];
  /** The id of the first pair that the edit adds, until the server gives one; further ones count down. */
  firstNewId: number;
}

/**
 * Edits that the server has not answered yet, on top of the last document that it sent. Pure: it knows neither network nor page, so
 * every order of answers can be tested.
 */
export class EditQueue {
  private document: Markers;
  private pending: PendingEdit[];
  private nextNewId: number;

  constructor(document: Markers, pending: readonly PendingEdit[] = []) {
    this.document = document;
    this.pending = [...pending];
    this.nextNewId = Math.min(-1, ...pending.map((edit) => edit.firstNewId - countAdds(edit.ops)));
  }

  /** The document as the person sees it. */
  get pairs(): Pair[] {
    let pairs: Pair[] = this.document.pairs;
    for (const edit of this.pending) pairs = applyOps(pairs, edit.ops, edit.firstNewId);
    return pairs;
  }

  get server(): Markers {
    return this.document;
  }

  get waiting(): readonly PendingEdit[] {
    return this.pending;
  }

  /** Puts an edit at the end; returns it with the ids of the pairs that it adds. */
  push(ops: Op[], id: string): { edit: PendingEdit; added: number[] } {
    const ids = new Set(ops.map((op) => ('pair' in op ? op.pair : null)));
    const names = this.document.pairs
      .map(({ id, name }, place) => ({ id, name, number: place + 1 }))
      .filter(({ id }) => ids.has(id));
    const edit: PendingEdit = { base: this.document.revision, id, ops, names, firstNewId: this.nextNewId };
    const count = countAdds(ops);
    const added = Array.from({ length: count }, (_, i) => this.nextNewId - i);
    this.nextNewId -= count;
    this.pending.push(edit);
    return { edit, added };
  }

  /** Takes back the newest edit that was not sent yet. */
  dropLast(sent: string | null): PendingEdit | null {
    const last = this.pending.at(-1);
    if (!last || last.id === sent) return null;
    return this.pending.pop() ?? null;
  }

  /** The server answered the first edit: it leaves, and later ones name the pairs by the ids that the server gave. */
  acknowledge(id: string, result: EditResult): Map<number, number> {
    const index = this.pending.findIndex((edit) => edit.id === id);
    const ids = new Map<number, number>();
    if (index >= 0) {
      const [edit] = this.pending.splice(index, 1);
      result.added.forEach((given, i) => {
        if (given !== null) ids.set(edit.firstNewId - i, given);
      });
      for (const later of this.pending) {
        later.ops = later.ops.map((op) => renumberOp(op, ids));
      }
    }
    this.receive(result.markers);
    return ids;
  }

  /** The server refused the edit as a whole. */
  reject(id: string): void {
    this.pending = this.pending.filter((edit) => edit.id !== id);
  }

  /** A document from the server; an older one than the present is news that came late. */
  receive(document: Markers): void {
    if (document.revision >= this.document.revision) this.document = document;
  }
}

function countAdds(ops: readonly Op[]): number {
  return ops.filter((op) => op.op === 'add').length;
}
