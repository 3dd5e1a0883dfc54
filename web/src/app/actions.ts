import { openMirrorDialog } from '../markers/mirror.ts';
import { doubtfulFirst, matches, neighbour, pairTitle } from '../markers/order.ts';
import { api, describeError } from '../protocol/client.ts';
import type { Pair, Status } from '../protocol/types.ts';
import { notify } from '../ui/notices.ts';
import { computed, flush, signal } from '../ui/signal.ts';
import type { Stage } from '../views/stage.ts';
import type { Studio } from './studio.ts';

/** What a person can do with pairs, by button or by key. */
export class Actions {
  readonly search = signal('');
  readonly order = signal<'doubtful' | 'number'>('doubtful');
  /** The pairs as the list shows them. */
  readonly listed: { readonly value: Pair[] };
  nameField: HTMLInputElement | null = null;
  private readonly studio: Studio;
  private readonly stage: Stage;

  constructor(studio: Studio, stage: Stage) {
    this.studio = studio;
    this.stage = stage;
    this.listed = computed(() => {
      const found = studio.markers.pairs.value.filter((pair) => matches(pair, this.search.value));
      return this.order.value === 'doubtful' ? doubtfulFirst(found) : found;
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
      notify(next.reason, null, 'info', 'next');
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error');
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
    this.studio.selected.value = after && after.id !== pair.id ? after.id : null;
    notify(`Deleted ${pairTitle(pair)}.`, 'Ctrl Z brings it back.');
  }

  rename(name: string): void {
    const pair = this.studio.markers.pair(this.studio.selected.peek());
    const given = name.trim() || null;
    if (pair && given !== pair.name) this.studio.markers.edit({ op: 'rename', pair: pair.id, name: given });
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
