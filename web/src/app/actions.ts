import { openMirrorDialog } from '../markers/mirror.ts';
import { doubtfulFirst, matches, needOf, neighbour, pairTitle } from '../markers/order.ts';
import { api, describeError, sentence } from '../protocol/client.ts';
import type { Pair, Status } from '../protocol/types.ts';
import { notify, settle } from '../ui/notices.ts';
import { computed, effect, flush, signal } from '../ui/signal.ts';
import { readableIn } from '../ui/words.ts';
import type { Stage } from '../views/stage.ts';
import type { Studio } from './studio.ts';

/** What a person can do with pairs, by button or by key. */
export class Actions {
  readonly search = signal('');
  readonly order = signal<'doubtful' | 'number'>('doubtful');
  /** The pairs as the list shows them. */
  readonly listed: { readonly value: Pair[] };
  nameField: HTMLInputElement | null = null;
  /** The pair that the last reason was about. */
  private readonly reasonOf = signal<number | null>(null);
  private readonly studio: Studio;
  private readonly stage: Stage;

  constructor(studio: Studio, stage: Stage) {
    this.studio = studio;
    this.stage = stage;
    this.listed = computed(() => {
      const found = studio.markers.pairs.value.filter((pair) => matches(pair, this.search.value));
      return this.order.value === 'doubtful' ? doubtfulFirst(found) : found;
    });
    // What undo brings back is shown.
    studio.history.onReturned = (ids) => {
      if (ids.length !== 1) return;
      studio.selected.value = ids[0];
      this.flyTo(ids[0]);
    };
    // Why a pair was shown holds no more once it is checked, or another one is selected.
    effect(() => {
      const id = this.reasonOf.value;
      const pair = studio.markers.pairs.value.find((other) => other.id === id);
      if (id === null || (studio.selected.value === id && pair && needOf(pair) !== 'none')) return;
      this.reasonOf.value = null;
      settle('next');
    });
  }

  select(step: 1 | -1): void {
    const pair = neighbour(this.listed.value, this.studio.selected.peek(), step);
    if (!pair) return;
    this.studio.selected.value = pair.id;
    this.flyTo(pair.id);
  }

  flyTo(id: number | null): void {
    const pair = this.studio.markers.pair(id);
    if (pair) this.stage.flyToPoints(pair.source, pair.target);
  }

  /** Shows the point that would help most. */
  async next(): Promise<void> {
    try {
      await this.studio.markers.settled();
      const next = await api.next(this.studio.selected.peek());
      this.studio.selected.value = next.pair;
      this.stage.flyToPoints(next.source, next.target);
      this.reasonOf.value = next.pair;
      notify(readableIn(sentence(next.reason)), null, 'info', 'next');
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error', 'next');
    }
  }

  /** Confirms the selected pair and goes on to the next one that needs a look. */
  confirm(): void {
    this.setStatus('confirmed');
  }

  skip(): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    if (pair?.status === 'skipped') this.studio.markers.edit({ op: 'status', pair: pair.id, status: 'confirmed' });
    else this.setStatus('skipped');
  }

  remove(): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    if (!pair) return;
    const after = neighbour(this.listed.value, pair.id, 1);
    this.studio.markers.edit({ op: 'delete', pair: pair.id });
    const next = after && after.id !== pair.id ? after.id : null;
    this.studio.selected.value = next;
    if (next !== null) this.flyTo(next);
    notify(`Deleted ${pairTitle(pair)}.`, 'Ctrl Z brings it back.');
  }

  rename(name: string): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    const given = name.trim() || null;
    // The field shows the title of a pair whose name comes from a stage.
    if (pair && given !== pair.name && name !== pairTitle(pair))
      this.studio.markers.edit({ op: 'rename', pair: pair.id, name: given });
  }

  editName(): void {
    this.studio.panel.value = 'points';
    flush();
    this.nameField?.focus();
    this.nameField?.select();
  }

  startNew(): void {
    this.stage.markerTool.startNew();
  }

  mirror(): void {
    openMirrorDialog(this.studio);
  }

  propose(): void {
    void this.studio.propose();
  }

  private setStatus(status: Status): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    if (!pair || pair.status === status) return;
    const list = this.listed.value;
    const after = list
      .slice(list.findIndex((other) => other.id === pair.id) + 1)
      .find((other) => other.status === 'proposed');
    const first = list.find((other) => other.status === 'proposed' && other.id !== pair.id);
    this.studio.markers.edit({ op: 'status', pair: pair.id, status });
    const next = after ?? first ?? null;
    if (!next) return;
    this.studio.selected.value = next.id;
    this.flyTo(next.id);
  }
}
