import type { MarkerStore } from '../markers/store.ts';
import type { Socket } from '../protocol/socket.ts';
import type { PipelineStore } from '../stages/store.ts';
import { notify } from '../ui/notices.ts';
import { past } from './past.ts';

/** What has steps: points and settings. */
interface Steps {
  markers: MarkerStore;
  pipeline: PipelineStore;
  socket: Socket;
}

/** One history over points and settings: what was done last is undone first, whatever it was. */
export class Undo {
  private readonly studio: Steps;
  private chain: Promise<void> = Promise.resolve();

  constructor(studio: Steps) {
    this.studio = studio;
  }

  /** Takes back the last step, or does one again, after those that are under way. */
  step(redo: boolean): Promise<void> {
    this.chain = this.chain.then(() => this.one(redo));
    return this.chain;
  }

  /** The step that is due: the newest that is done, or the oldest that was taken back. */
  due(redo: boolean): { title: string; of: 'markers' | 'pipeline' } | null {
    const markers = this.studio.markers.document.value;
    const pipeline = this.studio.pipeline.pipeline.value;
    const ofMarkers = {
      title: redo ? markers.redo : markers.undo,
      order: redo ? markers.redo_order : markers.undo_order,
    };
    const ofPipeline = {
      title: (redo ? pipeline?.redo : pipeline?.undo) ?? null,
      order: (redo ? pipeline?.redo_order : pipeline?.undo_order) ?? null,
    };
    if (ofMarkers.title === null && ofPipeline.title === null) return null;
    const first = redo ? 1 : -1;
    const markersFirst =
      ofPipeline.title === null ||
      (ofMarkers.title !== null && Math.sign((ofPipeline.order ?? 0) - (ofMarkers.order ?? 0)) === first);
    return markersFirst
      ? { title: ofMarkers.title ?? '', of: 'markers' }
      : { title: ofPipeline.title ?? '', of: 'pipeline' };
  }

  private async one(redo: boolean): Promise<void> {
    const { markers, pipeline, socket } = this.studio;
    if (!redo && socket.connection.peek() !== 'open' && markers.dropUnsent()) {
      notify('Undid the last change, which was not sent yet.', null, 'info', 'undo');
      return;
    }
    await Promise.all([markers.settled(), pipeline.settled()]);
    const due = this.due(redo);
    if (due === null) {
      notify(redo ? 'There is nothing to redo.' : 'There is nothing to undo.', null, 'info', 'undo');
      return;
    }
    const done = due.of === 'markers' ? await markers.step(redo) : await pipeline.step(redo);
    if (done) notify(`${redo ? 'Did again' : 'Undid'}: ${past(due.title)}.`, null, 'info', 'undo');
  }
}
