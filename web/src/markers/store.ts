import { api, ConnectionError, describeError, RequestError } from '../protocol/client.ts';
import type { Conflict, EditResult, Markers, Op, Pair } from '../protocol/types.ts';
import { signal } from '../ui/signal.ts';
import { counted } from '../ui/words.ts';
import { EMPTY } from './empty.ts';
import { withoutPartner } from './partners.ts';
import { EditQueue, type PendingEdit } from './queue.ts';
import { recoverEdits } from './recover.ts';

export interface Notice {
  text: string;
  hint: string | null;
}

const RETRY_MILLISECONDS = 1500;
/** The answers that say that the edit itself is wrong. Others, such as 401 of a server that was started anew, may pass. */
const HOPELESS = [400, 404, 413, 415, 422];

/**
 * The document of markers in the page. An edit shows at once and is sent in order; it stays in the browser's storage until the server
 * has it, so neither a lost connection nor a closed tab loses a click.
 */
export class MarkerStore {
  readonly pairs = signal<Pair[]>([]);
  readonly document = signal<Markers>(EMPTY);
  /** How many edits wait for an answer. */
  readonly waiting = signal(0);
  readonly conflicts = signal<Conflict[]>([]);
  /** Reports what the person should read. */
  onNotice: (notice: Notice) => void = () => {};
  /** New pairs got their ids from the server. */
  onRenumbered: (ids: ReadonlyMap<number, number>) => void = () => {};
  private queue = new EditQueue(EMPTY);
  private key = '';
  private project = 0;
  private readonly client = crypto.randomUUID();
  private sending: string | null = null;
  private heldBack: Markers | null = null;
  private timer = 0;
  /** Counts documents, so that answers to an earlier one are known. */
  private turn = 0;
  private idle: (() => void)[] = [];

  /** Takes the document of a project, with edits that an earlier page could not send. */
  open(project: number, file: string, document: Markers): void {
    this.project = project;
    this.key = `mimesh-edits:${file}`;
    this.conflicts.value = [];
    this.begin(document, readPending(this.key));
  }

  /** Takes the document of a server that may have been started anew since the last edit. */
  reopen(document: Markers): void {
    this.begin(document, this.queue.waiting);
  }

  /** A document that the server sent by itself. */
  receive(document: Markers): void {
    // It may hold the edit under way already, which would then show twice until the answer comes.
    if (this.sending !== null) {
      this.heldBack = document;
      return;
    }
    this.queue.receive(document);
    this.publish();
  }

  /** Makes one step of undo out of operations; returns the temporary ids of new pairs. */
  edit(...ops: Op[]): number[] {
    const { added } = this.queue.push(ops, crypto.randomUUID());
    this.publish();
    void this.pump();
    return added;
  }

  pair(id: number | null): Pair | null {
    return this.pairs.peek().find((pair) => pair.id === id) ?? null;
  }

  /** Takes back the last edit that was not sent yet, which needs no server; whether there was one. */
  dropUnsent(): boolean {
    const dropped = this.queue.dropLast(this.sending) !== null;
    if (dropped) this.publish();
    return dropped;
  }

  /** Takes back the last step that the server has, or does one again; whether it was done. */
  async step(redo: boolean): Promise<boolean> {
    await this.settled();
    const { revision } = this.queue.server;
    let done = false;
    try {
      const result = await (redo ? api.redo(this.project, revision) : api.undo(this.project, revision));
      this.queue.receive(result.markers);
      this.report(result);
      done = result.conflicts.length === 0;
    } catch (error) {
      const { message, hint } = describeError(error);
      this.onNotice({ text: message, hint });
    }
    this.publish();
    return done;
  }

  /** Sends what waits; called when the connection is back, too. */
  async pump(): Promise<void> {
    if (this.timer !== 0) {
      window.clearTimeout(this.timer);
      this.timer = 0;
      this.sending = null;
    }
    while (this.sending === null) {
      const edit = this.queue.waiting[0];
      if (!edit) break;
      this.sending = edit.id;
      const { turn, project, client } = this;
      const { base, id, ops } = edit;
      try {
        const result = await api.edit({ project, base, id, client, ops });
        // Another document was opened meanwhile; it has brought the edit itself.
        if (turn === this.turn) this.answered(edit, result);
      } catch (error) {
        if (turn === this.turn) this.failed(edit, error);
      }
    }
    if (this.queue.waiting.length === 0) for (const resolve of this.idle.splice(0)) resolve();
  }

  /** Resolves when the server has every edit. */
  settled(): Promise<void> {
    if (this.queue.waiting.length === 0) return Promise.resolve();
    return new Promise((resolve) => this.idle.push(resolve));
  }

  dismissConflict(conflict: Conflict): void {
    this.conflicts.value = this.conflicts.peek().filter((other) => other !== conflict);
  }

  private begin(document: Markers, pending: readonly PendingEdit[]): void {
    this.queue = new EditQueue(document, recoverEdits(pending, document));
    this.turn += 1;
    window.clearTimeout(this.timer);
    this.timer = 0;
    this.sending = null;
    this.heldBack = null;
    this.publish();
    void this.pump();
  }

  private answered(edit: PendingEdit, result: EditResult): void {
    this.sending = null;
    const ids = this.queue.acknowledge(edit.id, result);
    if (this.heldBack) this.queue.receive(this.heldBack);
    this.heldBack = null;
    if (ids.size > 0) this.onRenumbered(ids);
    this.report(result);
    this.publish();
  }

  private failed(edit: PendingEdit, error: unknown): void {
    // The edit stays first in the queue. Its id lets the server recognise it if it was done before the answer was lost.
    if (error instanceof ConnectionError || (error instanceof RequestError && !HOPELESS.includes(error.status))) {
      this.timer = window.setTimeout(() => void this.pump(), RETRY_MILLISECONDS);
      this.publish();
      return;
    }
    this.sending = null;
    this.queue.reject(edit.id);
    const { message, hint } = describeError(error);
    this.onNotice({ text: `An edit was refused: ${message}`, hint });
    this.publish();
  }

  private report(result: EditResult): void {
    if (result.conflicts.length > 0) this.conflicts.value = [...this.conflicts.peek(), ...result.conflicts];
    const { mirrored } = result;
    if (mirrored) {
      const hint = withoutPartner(mirrored.left, (id) => this.pair(id));
      this.onNotice({ text: `Added ${counted(mirrored.added, 'mirrored pair')}.`, hint });
    }
  }

  private publish(): void {
    this.pairs.value = this.queue.pairs;
    this.document.value = this.queue.server;
    this.waiting.value = this.queue.waiting.length;
    writePending(this.key, this.queue.waiting);
  }
}

function readPending(key: string): PendingEdit[] {
  try {
    return JSON.parse(localStorage.getItem(key) ?? '[]') as PendingEdit[];
  } catch {
    return [];
  }
}

function writePending(key: string, edits: readonly PendingEdit[]): void {
  if (!key) return;
  // Storage may be full or forbidden; the edits then live as long as the page.
  try {
    if (edits.length > 0) localStorage.setItem(key, JSON.stringify(edits));
    else localStorage.removeItem(key);
  } catch {}
}
